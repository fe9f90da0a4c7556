"""Path of a rigid tool in time: straight travels at constant speed, and holds."""

from __future__ import annotations

import math
from bisect import bisect_left
from itertools import accumulate
from typing import Self

from pydantic import model_validator

from ncf_fenicsx.parts import Settings, parameter
from ncf_fenicsx.units import Length, PositiveSpeed, PositiveTime

Vector = tuple[float, float, float]


class Segment(Settings):
    """One piece of a path: a travel with its speed, or a hold."""

    travel: tuple[Length, Length, Length] | None = parameter(None, description="displacement (x, y, z) of the tool")
    speed: PositiveSpeed | None = parameter(None, description="speed along the travel")
    hold: PositiveTime | None = parameter(None, description="time at rest, instead of travel and speed")

    @model_validator(mode="after")
    def _travel_or_hold(self) -> Self:
        moves = self.travel is not None and self.speed is not None and any(self.travel)
        rests = self.hold is not None
        if moves == rests or (rests and (self.travel or self.speed)):
            raise ValueError("expected either travel (not zero) with speed, or hold")
        return self

    @property
    def duration(self) -> float:
        """Time from start to end of the segment in s."""
        if self.travel is None or self.speed is None:
            return float(self.hold or 0.0)
        return math.hypot(*self.travel) / self.speed


def milestones(path: tuple[Segment, ...]) -> list[float]:
    """Times in s at which the segments of a path end: steps land on them."""
    return list(accumulate(segment.duration for segment in path))


def displacement(path: tuple[Segment, ...], time: float) -> Vector:
    """Displacement (m) of the tool from its start at a time (s)."""
    total = [0.0, 0.0, 0.0]
    for segment in path:
        share = min(max(time / segment.duration, 0.0), 1.0)
        time -= segment.duration
        for axis, length in enumerate(segment.travel or (0.0, 0.0, 0.0)):
            total[axis] += share * length
    return total[0], total[1], total[2]


def segment_number(path: tuple[Segment, ...], time: float) -> int:
    """Number of the segment that ends at or after a time (s), the last one after the end."""
    return max(min(bisect_left(milestones(path), time * (1 - 1e-12)), len(path) - 1), 0)


def closing_speed(path: tuple[Segment, ...], time: float) -> float:
    """Speed (m/s) at which the tool moves down in the segment that ends at or after a time (s), negative upwards."""
    segment = path[segment_number(path, time)]
    if segment.travel is None or segment.speed is None:
        return 0.0
    return -segment.speed * segment.travel[2] / math.hypot(*segment.travel)
