"""One step through time: begun, solved, judged, measured, and committed or rolled back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mechanics.stabilising_viscosity import Viscosity
from ncf_fenicsx.mechanics.time_error import TimeError
from ncf_fenicsx.mesh.state_fields import Location, StateField, commit, rollback
from ncf_fenicsx.tools import path as motion

Floats = NDArray[np.float64]
Measured = TypeVar("Measured")


@dataclass(frozen=True)
class Outcome:
    """How a solve ended.

    Attributes:
        converged: whether the solution holds.
        iterations: Newton iterations, without a last one that only polishes.
        reason: in words, why it ended.
        hopeless: whether no smaller step would hold either.
        negative_pivots: of the last factors, or a mode found without them; more than none in equilibrium is a loss of
            stability. None with LU.
        time_error: estimated local error in time over the largest pressure so far; 0 where laws do not follow time.
        too_long: whether the step failed by that error alone: its solution held.
        wandered: whether the step failed because its corrections did not get smaller.
    """

    converged: bool
    iterations: int
    reason: str
    hopeless: bool = False
    negative_pivots: int | None = None
    time_error: float = 0.0
    too_long: bool = False
    wandered: bool = False

    @property
    def failed(self) -> bool:
        """Whether there was no solution, and the step was not merely too long or interrupted."""
        return not (self.converged or self.too_long or self.hopeless)

    def followed_by(self, later: Outcome) -> Outcome:
        """This solve and one after it, as one."""
        return replace(later, iterations=self.iterations + later.iterations)


@dataclass(frozen=True)
class Effort:
    """What a solve may cost, and how good it has to be.

    Attributes:
        patience: factor on the iterations after which to give up.
        force_tolerance: force out of balance over the support force that is allowed at most.
        polishes: whether a balanced state is corrected once more, down to round-off.
        may_wander: whether a solve goes on to its last iteration though small corrections do not get smaller.
        must_shrink: whether it ends with the first small correction that is larger than the one before it in the same
            contact, and where large ones do not get smaller, too.
    """

    patience: float = 1.0
    force_tolerance: float = 1.0
    polishes: bool = False
    may_wander: bool = True
    must_shrink: bool = False


USUAL = Effort()
MOMENT = 0.02
"""Farthest motion over the layer's thickness for which fabric is guessed to go on where a tool turns. Laws that
follow a rate go on at theirs for a moment: a guess at rest is off by all of the rate's part, however short the step."""


class TimeStep:
    """Takes a problem from one committed state to the next; a step that fails leaves no trace.

    Args:
        problem: what is solved.
        solve: solves for the trial state, which the displacement then holds, of the step from a time by a size (s),
            0 at rest, with an effort.
        more: what is to be remembered beside the problem's own state.
        predicts: whether the last step predicts displacement and contact of the next one: so where equilibrium is
            sought, not in a march with inertia.
        shape_violation: in words, which shape of the trial state cannot be followed further; None if all can.

    Attributes:
        state: all that is committed, rolled back and kept in checkpoints.
        time: at the end of the present step in s.
        size: of the present step in s, 0 at rest.
        viscosity: what stabilises the stack; None before there was any.
        time_error: estimates the local error in time; None where no tolerance is given or laws do not follow time.
    """

    def __init__(
        self,
        problem: Problem,
        solve: Callable[[float, float, Effort], Outcome],
        more: Sequence[StateField] = (),
        predicts: bool = True,
        shape_violation: Callable[[], str | None] = lambda: None,
    ) -> None:
        self.problem, self._solve, self._predicts = problem, solve, predicts
        self._shape_violation = shape_violation
        controls = predicts and problem.scene.controls_time_error
        self.time_error = TimeError(problem) if controls else None
        self.viscosity: Viscosity | None = None
        nothing = np.zeros_like(problem.start.x.array)
        self._velocity = StateField("velocity", Location.NODES, nothing.copy(), self._new_velocity)
        self._drift = StateField("drift", Location.NODES, nothing.copy())
        self._push = StateField("push", Location.NODES, nothing.copy())
        self.state = [*problem.state, self._velocity, *more]
        self.state += self.time_error.state if self.time_error is not None else []
        self.state += [self._drift] if problem.scene.solver.may_stabilise else []
        self.state += [self._push] if problem.scene.solver.perturbation is not None else []
        self.time = self.size = 0.0
        self._failed = False
        self._segments = self._segments_at(0.0)
        set_clock(problem, 0.0, 0.0)

    def attempt(self, time: float, size: float, effort: Effort = USUAL, least_judged: float = 0.0) -> Outcome:
        """Try a step.

        Args:
            time: from which, in s.
            size: in s.
            effort: of the solve.
            least_judged: size in s up to which a step is taken whatever its local error in time.
        """
        self.begin(time, size)
        outcome = self._solve(time, size, effort)
        defect = self.problem.admissibility.violation() if outcome.converged else None
        if outcome.converged and defect is None:
            defect = self._shape_violation()
        if defect is not None:
            outcome = replace(outcome, converged=False, reason=defect)
        if outcome.converged and self.time_error is not None:
            outcome = self._judged(outcome, self.time_error.relative(), size <= least_judged)
        self._failed = outcome.failed
        if not outcome.converged:
            self.rollback(time)
            if self.problem.scene.solver.perturbation is not None and not outcome.hopeless:
                self.push(-0.5 * self._push.committed)
        return outcome

    def _judged(self, outcome: Outcome, error: float, any_error: bool) -> Outcome:
        """An outcome whose step is too long for its local error in time does not hold."""
        tolerance = self.problem.scene.solver.time_tolerance
        if error <= tolerance or any_error:
            return replace(outcome, time_error=error)
        reason = f"local error in time of {100 * error:.2g} %, above solver.time_tolerance = {100 * tolerance:g} %"
        return replace(outcome, converged=False, time_error=error, too_long=True, reason=reason)

    def accept(self, measure: Callable[[], Measured]) -> Measured:
        """Measure the trial state, then commit it; what was measured."""
        measured = measure()
        self.commit()
        return measured

    def begin(self, time: float, size: float) -> None:
        """Put the tools where they are after a step from ``time`` by ``size`` (s), and predict the displacement."""
        self.time, self.size = time + size, size
        if not self._predicts:
            move_tools(self.problem, time, size)
            return
        problem, start = self.problem, self.problem.start.x.array
        same_way = self.in_same_segments(self.time)
        moves_on = same_way or self._moves_on(size)
        if problem.last_iterate is not None:
            problem.last_iterate.x.array[:] = start
        problem.displacement.x.array[:] = start + (size * self._velocity.committed if moves_on else 0.0)
        set_clock(problem, self.time, size)
        if self.time_error is not None:
            self.time_error.begin(size, same_way)
        problem.contacts.begin(time, size)
        problem.contacts.refresh()
        self._drift.values *= same_way
        if self.viscosity is not None:
            self.viscosity.expect(start + size * self._drift.values)

    def commit(self) -> None:
        """Accept the trial state."""
        commit(self.state)
        self._rest(self.time)

    def rollback(self, time: float) -> None:
        """Return to the committed state at ``time`` (s), bit for bit."""
        rollback(self.state)
        self.time, self.size = time, 0.0
        self.problem.contacts.rollback(time)
        set_clock(self.problem, time, 0.0)

    def resume(self, time: float) -> None:
        """Go on from a committed state that has been read back, at a time (s)."""
        self.rollback(time)
        self._rest(time)

    def _rest(self, time: float) -> None:
        """Tools at rest at a time (s), layers paired anew."""
        set_clock(self.problem, time, 0.0)
        self.problem.contacts.rest(time)
        self._segments = self._segments_at(time)

    def push(self, change: Floats) -> None:
        """Push the committed stack by so much (m, this rank's local dofs); halved as often as the next step fails."""
        problem = self.problem
        problem.start.x.array[:] += change
        problem.displacement.x.array[:] = problem.start.x.array
        problem.contacts.refresh()
        self._push.commit(self._push.values + change)

    def forget_push(self) -> None:
        """Let the push be: a step has held with it."""
        self._push.commit(np.zeros_like(self._push.values))

    def stabilise(self, coefficient: float) -> None:
        """Let a viscosity (Pa s/m2) act against motion that departs from the drift; its term comes with the first."""
        problem = self.problem
        if coefficient and self.viscosity is None:
            inverse = problem.clock.inverse_time_step
            self.viscosity = Viscosity(problem.displacement, problem.constants(0.0), inverse)
            problem.add_term("viscosity", self.viscosity.work(problem.variation) * problem.volumes.all)
        if self.viscosity is not None:
            self.viscosity.coefficient.value = coefficient

    def drift_on(self) -> None:
        """Have a viscosity not resist a motion such as that of the last step."""
        self._drift.commit(self._velocity.committed)

    def _new_velocity(self) -> Floats:
        """Mean velocity in m/s over the step, which predicts the next one."""
        moved = self.problem.displacement.x.array - self.problem.start.x.array
        return moved / self.size if self.size else np.zeros_like(moved)

    def in_same_segments(self, time: float) -> bool:
        """Whether the tools are in the segments of their paths at a time (s) in which they are now."""
        return self._segments_at(time) == self._segments

    def _moves_on(self, size: float) -> bool:
        """Whether a step (s) in which a tool turns is short enough for motion to go on in its guess; collective.

        So with friction, whose searches are long, and where a step has just failed from a guess at rest; not where a
        tool's height is an unknown, which would be guessed, too.
        """
        problem = self.problem
        if problem.contacts.controls or not (problem.scene.solver.searches or self._failed):
            return False
        farthest = size * float(np.abs(self._velocity.committed).max(initial=0.0))
        return problem.comm.allreduce(farthest, MPI.MAX) <= MOMENT * problem.scales.length

    def _segments_at(self, time: float) -> list[int]:
        """Number of each tool's segment that ends at or after a time (s)."""
        return [motion.segment_number(tool.path, time) for tool in self.problem.scene.tool]


def move_tools(problem: Problem, time: float, size: float) -> None:
    """Put the tools where they are after a step from ``time`` by ``size`` (s); the trial displacement stays."""
    set_clock(problem, time + size, size)
    problem.contacts.move_tools(time, size)


def set_clock(problem: Problem, time: float, size: float) -> None:
    """Tell the laws the size of the step (s) that ends at a time (s), 0 at rest, and how fast the tools close in."""
    paths = [tool.path for tool in problem.scene.tool]
    speeds = [motion.closing_speed(path, time) for path in paths] if size else []
    problem.clock.set(size, max(speeds, key=abs, default=0.0))
    travels = [path[motion.segment_number(path, time)].travel for path in paths]
    problem.scales.sliding = any(travel is not None and any(travel[:2]) for travel in travels)
