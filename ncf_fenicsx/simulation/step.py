"""One step of a run tried, and the first state, at rest under the stack's weight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.state_parts import Place, StatePart
from ncf_fenicsx.simulation.stabilisation import Steadying
from ncf_fenicsx.simulation.stepping import Ending, March, StepControl, march
from ncf_fenicsx.solver import Newton, Outcome

Floats = NDArray[np.float64]


SHARES = StepControl(first=1.0, smallest=1e-3, largest=1.0, growth=2.0, cut=0.25, target_iterations=10, max_steps=200)
"""Shares of the weight, in place of time."""
PATIENCE = 4
"""Layers that bend by their weight part from each other row by row of nodes, one in each of Newton's iterations."""


class StepSolver:
    """Tries steps; one that fails leaves no trace in the problem's state.

    Args:
        problem: what is solved.
        newton: solves it.
        steadying: viscosity of the run.

    Attributes:
        iterations: Newton iterations so far, those of failed steps included.
    """

    def __init__(self, problem: Problem, newton: Newton, steadying: Steadying) -> None:
        self.problem, self.newton, self.steadying = problem, newton, steadying
        self.iterations = 0
        self._push = np.zeros_like(problem.displacement.x.array)

    def attempt(self, time: float, size: float, patience: int = 1) -> Outcome:
        """Try the step from a time by a size (s), with a factor on Newton's iterations."""
        self.problem.steady(self.steadying.value)
        self.problem.begin(time, size)
        outcome = self._solve(patience, at_rest=not size)
        self.iterations += outcome.iterations
        defect = self.problem.defects.find() if outcome.converged else None
        if defect is not None:
            outcome = replace(outcome, converged=False, reason=defect)
        if not outcome.converged:
            self.problem.rollback(time)
            if size:
                self.steadying.failed(size)
            if self.problem.scene.solver.perturbation is not None:
                self.push(-0.5 * self._push)
        return outcome

    def push(self, change: Floats) -> None:
        """Push the committed stack by so much (m, this rank's local dofs); halved as often as the next step fails."""
        self.problem.perturb(change)
        self._push += change

    def held(self, size: float) -> None:
        """Go on after a step of a size (s) that was accepted."""
        self._push[:] = 0.0
        self.steadying.held(size)
        if not (self.steadying.value and self.steadying.in_trouble(size)):
            self.problem.drift_on()

    def parts(self) -> dict[str, StatePart]:
        """What a checkpoint has to keep, if the scene asks for a push."""
        if self.problem.scene.solver.perturbation is None:
            return {}
        return {
            "push": StatePart(Place.NODES, lambda: self._push, lambda rows: np.copyto(self._push, rows.ravel())),
        }

    def _solve(self, patience: int, at_rest: bool) -> Outcome:
        """Newton's method, again after each update of multipliers that a penetration above its tolerance asks for."""
        outcome, updates = self.newton.solve(patience, at_rest), 0
        while outcome.converged and (augmented := self.problem.contacts.augment()) is not None:
            penetration, most = augmented
            updates += 1
            if updates > most:
                reason = f"penetration of {1e6 * penetration:.3g} um after {most} updates of the multipliers"
                return Outcome(False, outcome.iterations, reason)
            outcome = outcome.followed_by(self.newton.solve(patience, at_rest))
        return outcome


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
