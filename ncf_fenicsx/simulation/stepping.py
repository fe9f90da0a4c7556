"""Step control: try, accept, cut. Pure: it knows neither meshes nor solvers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import NamedTuple, Protocol, TypeVar

from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.settings import Solver


class Attempt(Protocol):
    """What trying a step tells."""

    @property
    def converged(self) -> bool:
        """Whether the step holds."""

    @property
    def iterations(self) -> int:
        """Newton iterations it took."""

    @property
    def reason(self) -> str:
        """In words, why it holds or not."""

    @property
    def hopeless(self) -> bool:
        """Whether no smaller step would hold either."""

    @property
    def time_error(self) -> float:
        """Estimated local error in time, 0 where there is none."""

    @property
    def too_long(self) -> bool:
        """Whether the step failed by that error alone."""


FIRST_STEPS = 30
"""Steps of the first one's size that a piece of a path has unless given."""
AIM = 0.7
"""Share of the tolerance in time that the next step aims at."""
LEAST_FOR_ERROR = 0.1
"""Share of the first step of a piece below which no step is taken again for its error in time."""
SHRINK = 0.5
"""Factor after a step that took more than one and a half times its target of iterations, where corrections are searched
along: round-off (another number of ranks) changes how many a long search takes, and must not change the steps."""
BAND = 1.25
"""Sizes that follow the error do so in bands: round-off (another number of ranks) does not change them."""
Tried = TypeVar("Tried", bound=Attempt)


class Ending(Enum):
    """How a march ended."""

    DONE = "done"
    STOPPED = "stopped"


@dataclass(frozen=True)
class StepControl:
    """Sizes of time steps.

    Attributes:
        first: first step in s.
        smallest: step in s below which a march stops.
        largest: largest step in s.
        growth: factor after a step that took fewer iterations than the target.
        cut: factor on a step that failed.
        target_iterations: iterations, up to half as many more, that keep the size.
        max_steps: accepted steps at which a march stops.
        time_tolerance: local error in time that a step may have.
        searches: whether Newton's corrections are searched along.
    """

    first: float
    smallest: float
    largest: float
    growth: float
    cut: float
    target_iterations: int
    max_steps: int
    time_tolerance: float = 1.0
    searches: bool = False

    @classmethod
    def of(cls, settings: Solver, duration: float, controls_time_error: bool) -> StepControl:
        """That of a scene's settings for a piece of its path; sizes not given are shares of its duration (s).

        Nothing is known of the local error in time before the first step of a piece: where that is controlled, this
        step is never longer than the share.
        """
        share, finer = duration / FIRST_STEPS, settings.step_refinement
        given = settings.first_step or share
        first = (min(given, share) if controls_time_error else given) / finer
        return cls(
            first=first,
            smallest=min(settings.smallest_step or first / 1e4, first),
            largest=(settings.largest_step or duration / 8) / finer,
            growth=settings.growth,
            cut=settings.cut,
            target_iterations=settings.target_iterations,
            max_steps=settings.max_steps,
            time_tolerance=settings.time_tolerance,
            searches=settings.searches,
        )

    def next_size(self, size: float, iterations: int) -> float:
        """Size (s) after a step that took some iterations.

        The size follows bands of iterations, not their exact number, so that round-off (another number of ranks)
        does not change the times of a history.
        """
        factor = self.growth if iterations < self.target_iterations else 1.0
        if 2 * iterations > 3 * self.target_iterations:
            factor = SHRINK if self.searches else self.target_iterations / iterations
        return max(min(size * factor, self.largest), self.smallest)

    @property
    def least_for_error(self) -> float:
        """Step in s that is taken whatever its local error in time.

        Where nodes come into contact one after the other, the error that they make is of the mesh: it does not go away
        with the step, and steps would become as short as Newton's method makes them.
        """
        return LEAST_FOR_ERROR * self.first

    def size_allowed(self, size: float, error: float) -> float:
        """Step in s that leaves the local error in time, of first order, below the tolerance; in bands."""
        if error <= 0:
            return math.inf
        share = float(BAND ** math.floor(math.log(AIM * self.time_tolerance / error, BAND)))
        return max(share * size, self.least_for_error)

    @staticmethod
    def fit(size: float, remaining: float) -> float:
        """Step near ``size``, never above it, of which equal ones fill the last three before a milestone."""
        return remaining / max(math.ceil(remaining / size - 1e-9), 1) if remaining < 3 * size else size


@dataclass
class March:
    """Progress of a march through time.

    Attributes:
        time: time reached in s.
        size: size in s of the next step to try.
        steps: accepted steps.
        cuts: steps cut so far.
        fresh: whether a piece is still to be begun.
        ending: how it ended.
        reason: in words.
    """

    time: float = 0.0
    size: float = 0.0
    steps: int = 0
    cuts: int = 0
    fresh: bool = True
    ending: Ending = Ending.DONE
    reason: str = "end of the path reached"

    def begin_piece(self, control: StepControl, before: StepControl) -> None:
        """Begin a piece with its own first step; where steps have failed in the one before, with none longer."""
        trouble, first = self.size < before.least_for_error, min(control.first, control.largest)
        self.size, self.fresh = min(self.size, first) if trouble else first, False

    def stop(self, reason: str) -> March:
        """End the march before its time."""
        self.ending, self.reason = Ending.STOPPED, reason
        return self


class Piece(NamedTuple):
    """A piece of a march.

    Attributes:
        end: time in s that steps land on.
        control: sizes of its steps.
    """

    end: float
    control: StepControl


def pieces(scene: Scene) -> list[Piece]:
    """Pieces of the path of a scene, each with its own sizes: what comes later changes nothing before it."""
    ends = scene.milestones
    controls = [
        StepControl.of(scene.solver, end - start, scene.controls_time_error) for start, end in pairwise([0.0, *ends])
    ]
    return [Piece(*pair) for pair in zip(ends, controls, strict=True)]


def march(
    pieces: Sequence[Piece],
    attempt: Callable[[float, float, StepControl], Tried],
    accept: Callable[[March, float, Tried], None],
    progress: March | None = None,
    longest: Callable[[float, float], float] = lambda time, size: size,  # noqa: ARG005
) -> March:
    """Step through all pieces.

    Args:
        pieces: with their ends, ascending.
        attempt: tries the step from a time by a size (s) in a piece of such steps, and leaves no trace if it fails.
        accept: told the march at its new time, the size of the step (s) and its attempt.
        progress: march to go on with; from time 0 unless given.
        longest: step (s) from a time, no longer than a size, that may be taken.
    """
    progress = progress or March(size=math.inf)
    before = pieces[0].control
    for milestone, control in pieces:
        if progress.time < milestone and progress.fresh:
            progress.begin_piece(control, before)
        before = control
        while progress.time < milestone:
            if progress.steps >= control.max_steps:
                return progress.stop(f"max_steps = {control.max_steps} reached")
            remaining = milestone - progress.time
            step = longest(progress.time, wanted := control.fit(progress.size, remaining))
            outcome = attempt(progress.time, step, control)
            if outcome.converged:
                progress.fresh = step == remaining
                progress.time = milestone if progress.fresh else progress.time + step
                progress.steps += 1
                shortened = progress.fresh or step < wanted
                progress.size = control.next_size(max(step, progress.size) if shortened else step, outcome.iterations)
                progress.size = min(progress.size, control.size_allowed(step, outcome.time_error))
                accept(progress, step, outcome)
                continue
            if outcome.hopeless:
                return progress.stop(outcome.reason)
            progress.cuts += 1
            progress.size = control.size_allowed(step, outcome.time_error) if outcome.too_long else control.cut * step
            if progress.size < control.smallest:
                return progress.stop(f"{outcome.reason}, even with the smallest time step ({step:.3g} s)")
    return progress
