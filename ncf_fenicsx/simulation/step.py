"""One step of a run tried, and what a failure leads to; the first state, at rest under the stack's weight."""

from __future__ import annotations

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mechanics.time_step import USUAL, Effort, Outcome, TimeStep
from ncf_fenicsx.simulation.stabilisation import TROUBLE, Stabilisation
from ncf_fenicsx.simulation.stepping import Ending, March, Piece, StepControl, march
from ncf_fenicsx.solver import Newton

SHARES = StepControl(first=1.0, smallest=1e-3, largest=1.0, growth=2.0, cut=0.25, target_iterations=30, max_steps=1000)
"""Shares of the weight, in place of time; many iterations each, as faces meet row by row of nodes."""
AT_REST = Effort(patience=4.0, force_tolerance=1e-7)
"""Layers that bend by their weight part from each other row by row of nodes, one in each of Newton's iterations.
What is left over would be motion of the first step."""
BRIEF = 1.25
"""Times the target of iterations at which a step with a viscosity is given up, where corrections are searched along. A
shorter one has a state near the last; which of several states a long search finds depends on round-off, which grows
with each of its iterations."""
LAST_RESORT = 1e-3
"""Share of the first step of a piece below which a step is not given up sooner than without a viscosity: few are left
to try. Nor is one in trouble in which a tool turns: a shorter one is hardly nearer to the state before."""
SNAPPING = 1e-10
"""Force tolerance with a viscosity: while the stack snaps, what is left over grows a thousandfold and more."""


class AugmentedNewton:
    """Newton's method, again after each update of multipliers that a penetration above its tolerance asks for.

    Args:
        problem: what is solved.
        newton: solves it with the multipliers as they are.
    """

    def __init__(self, problem: Problem, newton: Newton) -> None:
        self._problem, self._newton = problem, newton

    def solve(self, time: float, size: float, effort: Effort) -> Outcome:
        """Solve from the present displacement for the end of a step (s), with an effort for each solution."""
        del time, size
        outcome, updates = self._newton.solve(effort), 0
        while outcome.converged and (augmented := self._problem.contacts.augment()) is not None:
            penetration, most = augmented
            updates += 1
            if updates > most:
                reason = f"penetration of {1e6 * penetration:.3g} um after {most} updates of the multipliers"
                return Outcome(False, outcome.iterations, reason)
            outcome = outcome.followed_by(self._newton.solve(effort))
        return outcome


class StabilisedStep:
    """Tries steps, with a viscosity where they fail again and again.

    Args:
        time_step: takes the problem from state to state.
        stabilisation: decides on the viscosity.

    Attributes:
        iterations: Newton iterations so far, those of failed steps included.
        wandered: the last step in which corrections have wandered, as a share of its piece's first one, until one as
            long holds; 0 if none. Shorter ones are given up at the first sign of that: a still shorter one stays on the
            path.
        piece: first step in s of the piece of the path that it is in; None before the first one.
    """

    def __init__(self, time_step: TimeStep, stabilisation: Stabilisation) -> None:
        self.time_step, self.stabilisation = time_step, stabilisation
        self.iterations = 0
        self.wandered = self._share = 0.0
        self.piece: float | None = None

    def attempt(self, time: float, size: float, control: StepControl) -> Outcome:
        """Try the step from a time by a size (s), of a piece with such steps."""
        if self.piece not in (None, control.first):
            self.wandered = 0.0
        self.piece, self._share = control.first, size / control.first
        return self._attempt(time, size, self._effort(time + size), control.least_for_error)

    def _effort(self, end: float) -> Effort:
        """That of a step that ends at a time (s)."""
        settings = self.time_step.problem.scene.solver
        stable = settings.line_search == "full" and not self.stabilisation.stability_lost
        if stable and self._share > TROUBLE:  # shorter ones that fail bring a viscosity
            return Effort(may_wander=False, must_shrink=self._share < self.wandered)
        if not self.stabilisation.value or not settings.searches:
            return USUAL
        turns = not self.time_step.in_same_segments(end)
        patient = self._share < LAST_RESORT or (turns and self.stabilisation.in_trouble(self._share))
        brief = min(BRIEF * settings.target_iterations / settings.max_iterations, 1.0)
        return Effort(1.0 if patient else brief, SNAPPING, polishes=True)

    def at_rest(self) -> Outcome:
        """Try to bring the stack to rest under the present share of its weight."""
        return self._attempt(0.0, 0.0, AT_REST, 0.0)

    def _attempt(self, time: float, size: float, effort: Effort, least_judged: float) -> Outcome:
        self.time_step.stabilise(self.stabilisation.value)
        outcome = self.time_step.attempt(time, size, effort, least_judged)
        self.iterations += outcome.iterations
        if outcome.wandered:
            self.wandered = self._share
        elif (outcome.converged or outcome.too_long) and self._share >= self.wandered:
            self.wandered = 0.0
        if size and outcome.failed:
            self.stabilisation.failed(self._share)
        return outcome

    def held(self) -> None:
        """Go on after the last step, which was accepted."""
        self.time_step.forget_push()
        self.stabilisation.held(self._share)
        if not (self.stabilisation.value and self.stabilisation.in_trouble(self._share)):
            self.time_step.drift_on()


class Settling:
    """Brings the stack to rest, in parts of its weight where all at once fails.

    Args:
        steps: solves for each part.

    Attributes:
        outcome: of all parts together.
    """

    def __init__(self, steps: StabilisedStep) -> None:
        self.steps = steps
        self.outcome = Outcome(True, 0, "")

    def run(self) -> March:
        """The march at time 0; its end says whether the stack rests, in the trial state."""
        ended = march([Piece(1.0, SHARES)], self._attempt, self._accept)
        if ended.ending is Ending.DONE:
            return March()
        return March().stop(f"the stack does not come to rest under its own weight: {ended.reason}")

    def _attempt(self, carried: float, more: float, control: StepControl) -> Outcome:
        """Try to carry more of the weight, as shares of it."""
        del control
        self.steps.time_step.problem.weight_share.value = carried + more
        return self.steps.at_rest()

    def _accept(self, progress: March, more: float, outcome: Outcome) -> None:
        del more
        self.outcome = self.outcome.followed_by(outcome)
        if progress.time < 1.0:
            self.steps.time_step.commit()
