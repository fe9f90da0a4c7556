"""A stack that comes to rest under its own weight, before anything moves."""

from __future__ import annotations

from ncf_fenicsx.simulation.step_solver import StepSolver
from ncf_fenicsx.simulation.stepping import Ending, March, StepControl, march
from ncf_fenicsx.solver import Outcome

SHARES = StepControl(first=1.0, smallest=1e-3, largest=1.0, growth=2.0, cut=0.25, target_iterations=10, max_steps=200)
"""Shares of the weight, in place of time."""
PATIENCE = 4
"""Layers that bend by their weight part from each other row by row of nodes, one in each of Newton's iterations."""


class Settling:
    """Brings the stack to rest, in parts of its weight where all at once fails.

    Args:
        steps: solves for each part.

    Attributes:
        outcome: of all parts together.
    """

    def __init__(self, steps: StepSolver) -> None:
        self.steps, self.problem = steps, steps.problem
        self.outcome = Outcome(True, 0, "")

    def run(self) -> March:
        """The march at time 0; its end says whether the stack rests, in the trial state."""
        ended = march(SHARES, [1.0], self._attempt, self._accept)
        if ended.ending is Ending.DONE:
            return March()
        return March().stop(f"the stack does not come to rest under its own weight: {ended.reason}")

    def _attempt(self, carried: float, more: float) -> Outcome:
        """Try to carry more of the weight, as shares of it."""
        self.problem.weight_share.value = carried + more
        return self.steps.attempt(0.0, 0.0, PATIENCE)

    def _accept(self, progress: March, more: float, outcome: Outcome) -> None:
        del more
        self.outcome = self.outcome.followed_by(outcome)
        if progress.time < 1.0:
            self.problem.commit(0.0)
