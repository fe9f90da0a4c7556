"""One step of a run tried: Newton's method, multipliers, impossible states, viscosity where all else fails."""

from __future__ import annotations

from dataclasses import replace

from ncf_fenicsx.problem import Problem
from ncf_fenicsx.solver import Newton, Outcome
from ncf_fenicsx.steadying import Steadying


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

    def attempt(self, time: float, size: float, patience: int = 1) -> Outcome:
        """Try the step from a time by a size (s), with a factor on Newton's iterations."""
        self.problem.steady(self.steadying.value)
        self.problem.begin(time, size)
        outcome = self._solve(patience)
        self.iterations += outcome.iterations
        defect = self.problem.defects.find() if outcome.converged else None
        if defect is not None:
            outcome = replace(outcome, converged=False, reason=defect)
        if not outcome.converged:
            self.problem.rollback(time)
            self.steadying.failed(size)
        return outcome

    def _solve(self, patience: int) -> Outcome:
        """Newton's method, again after each update of multipliers that a penetration above its tolerance asks for."""
        outcome, updates = self.newton.solve(patience), 0
        while outcome.converged and (augmented := self.problem.contacts.augment()) is not None:
            penetration, most = augmented
            updates += 1
            if updates > most:
                reason = f"penetration of {1e6 * penetration:.3g} um after {most} updates of the multipliers"
                return Outcome(False, outcome.iterations, reason)
            outcome = outcome.followed_by(self.newton.solve(patience))
        return outcome
