"""Path of a rigid tool in time: straight travels at constant speed, holds, and forces that are kept or ramped."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from itertools import accumulate
from typing import Self

from pydantic import model_validator

from ncf_fenicsx.parameters.kinds import Settings, parameter
from ncf_fenicsx.parameters.units import Length, PositiveForce, PositiveSpeed, PositiveTime

Vector = tuple[float, float, float]


class Segment(Settings):
    """One piece of a path: a travel with its speed, or a hold; under a force, the tool finds its own height."""

    travel: tuple[Length, Length, Length] | None = parameter(None, description="displacement (x, y, z) of the tool")
    speed: PositiveSpeed | None = parameter(None, description="speed along the travel")
    hold: PositiveTime | None = parameter(None, description="time at rest, instead of travel and speed")
    force: PositiveForce | None = parameter(
        None, description="upward force on the tool at the segment's end, reached by a ramp; its height then follows"
    )
    roll: bool = parameter(False, description="whether the tool turns so that its tip does not slide; else it slides")

    @model_validator(mode="after")
    def _travel_or_hold(self) -> Self:
        moves = self.travel is not None and self.speed is not None and any(self.travel)
        rests = self.hold is not None
        if moves == rests or (rests and (self.travel or self.speed)):
            raise ValueError("expected either travel (not zero) with speed, or hold")
        if self.force is not None and self.travel is not None and self.travel[2]:
            raise ValueError("expected a travel without a height, which the force decides")
        if self.roll and not (self.travel and any(self.travel[:2])):
            raise ValueError("expected a travel along the surface to roll along")
        return self

    @property
    def duration(self) -> float:
        """Time from start to end of the segment in s."""
        if self.travel is None or self.speed is None:
            return float(self.hold or 0.0)
        return math.hypot(*self.travel) / self.speed

    @property
    def closing_speed(self) -> float:
        """Speed at which the tool moves down in m/s, negative upwards; 0 at rest."""
        if self.travel is None or self.speed is None:
            return 0.0
        return -self.speed * self.travel[2] / math.hypot(*self.travel)


def milestones(path: tuple[Segment, ...]) -> list[float]:
    """Times in s at which the segments of a path end: steps land on them."""
    return list(accumulate(segment.duration for segment in path))


def displacement(path: tuple[Segment, ...], time: float) -> Vector:
    """Displacement (m) of the tool from its start at a time (s), without what forces add to its height."""
    return _travelled(path, time, lambda _: True)


def rolled(path: tuple[Segment, ...], time: float) -> Vector:
    """The part of that displacement (m) that the tool has rolled along."""
    return _travelled(path, time, lambda segment: segment.roll)


def _travelled(path: tuple[Segment, ...], time: float, counts: Callable[[Segment], bool]) -> Vector:
    total = [0.0, 0.0, 0.0]
    for segment in path:
        share = min(max(time / segment.duration, 0.0), 1.0)
        time -= segment.duration
        if counts(segment):
            for axis, length in enumerate(segment.travel or (0.0, 0.0, 0.0)):
                total[axis] += share * length
    return total[0], total[1], total[2]


def segment_number(path: tuple[Segment, ...], time: float) -> int:
    """Number of the segment that ends at or after a time (s), the last one after the end."""
    return max(min(bisect_left(milestones(path), time * (1 - 1e-12)), len(path) - 1), 0)


def force(path: tuple[Segment, ...], time: float, at_start: float) -> float | None:
    """Force (N) that the tool has to carry at a time (s); None where its travel decides its height.

    Args:
        path: of the tool.
        time: in s.
        at_start: force in N at the start of the segment, from which it is ramped to the segment's own.
    """
    number = segment_number(path, time)
    segment = path[number]
    if segment.force is None:
        return None
    left = sum(earlier.duration for earlier in path[: number + 1]) - time
    return segment.force + (at_start - segment.force) * min(max(left / segment.duration, 0.0), 1.0)


def speed_after(path: tuple[Segment, ...], time: float) -> float:
    """Speed (m/s) of the tool in the segment that goes on after a time (s), 0 after the last."""
    ended = bisect_right(milestones(path), time * (1 + 1e-12))
    return (path[ended].speed or 0.0) if ended < len(path) else 0.0


def closing_speed(path: tuple[Segment, ...], time: float) -> float:
    """Speed (m/s) at which the tool moves down in the segment that ends at or after a time (s), negative upwards."""
    ended = time > milestones(path)[-1] * (1 + 1e-12)
    return 0.0 if ended else path[segment_number(path, time)].closing_speed
