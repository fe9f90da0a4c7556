"""Step control: try, accept, cut. Pure: it knows neither meshes nor solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol, TypeVar

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
    """

    first: float
    smallest: float
    largest: float
    growth: float
    cut: float
    target_iterations: int
    max_steps: int

    @classmethod
    def of(cls, settings: Solver, duration: float) -> StepControl:
        """That of a scene's settings, sizes that these do not name taken from its duration (s)."""
        first = settings.first_step or duration / 30
        return cls(
            first=first,
            smallest=settings.smallest_step or first / 1e4,
            largest=settings.largest_step or duration / 8,
            growth=settings.growth,
            cut=settings.cut,
            target_iterations=settings.target_iterations,
            max_steps=settings.max_steps,
        )

    def next_size(self, size: float, iterations: int) -> float:
        """Size (s) after a step that took some iterations.

        The size follows bands of iterations, not their exact number, so that round-off (another number of ranks)
        does not change the times of a history.
        """
        factor = self.target_iterations / iterations if 2 * iterations > 3 * self.target_iterations else 1.0
        factor = self.growth if iterations < self.target_iterations else factor
        return max(min(size * factor, self.largest), self.smallest)

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
        ending: how it ended.
        reason: in words.
    """

    time: float = 0.0
    size: float = 0.0
    steps: int = 0
    cuts: int = 0
    ending: Ending = Ending.DONE
    reason: str = "end of the path reached"

    def stop(self, reason: str) -> March:
        """End the march before its time."""
        self.ending, self.reason = Ending.STOPPED, reason
        return self


def march(
    control: StepControl,
    milestones: list[float],
    attempt: Callable[[float, float], Tried],
    accept: Callable[[March, float, Tried], None],
    progress: March | None = None,
    longest: Callable[[float, float], float] = lambda time, size: size,  # noqa: ARG005
) -> March:
    """Step through all milestones.

    Args:
        control: sizes of steps.
        milestones: times in s, ascending, that steps land on.
        attempt: tries the step from a time by a size (s), and leaves no trace if it fails.
        accept: told the march at its new time, the size of the step (s) and its attempt.
        progress: march to go on with; from time 0 unless given.
        longest: step (s) from a time, no longer than a size, that may be taken.
    """
    progress = progress or March(size=min(control.first, control.largest))
    for milestone in milestones:
        while progress.time < milestone:
            if progress.steps >= control.max_steps:
                return progress.stop(f"max_steps = {control.max_steps} reached")
            remaining = milestone - progress.time
            wanted = control.fit(progress.size, remaining)
            step = longest(progress.time, wanted)
            outcome = attempt(progress.time, step)
            if outcome.converged:
                progress.time = milestone if step == remaining else progress.time + step
                progress.steps += 1
                shortened = step == remaining or step < wanted
                reached = max(step, progress.size) if shortened else step
                progress.size = control.next_size(reached, outcome.iterations)
                accept(progress, step, outcome)
                continue
            if outcome.hopeless:
                return progress.stop(outcome.reason)
            progress.cuts += 1
            progress.size = control.cut * step
            if progress.size < control.smallest:
                return progress.stop(f"{outcome.reason}, even with the smallest time step ({step:.3g} s)")
    return progress
