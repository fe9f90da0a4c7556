"""What a level will cost: from the numbers of its scene before anything has run, then from the levels that ran."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ncf_fenicsx.mesh.memory import expected_memory
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.stepping import StepControl, pieces

SECONDS_PER_UNKNOWN_AND_STEP = 8e-5
"""Measured with the demos on one rank of an AMD EPYC: 5e-5 to 1.7e-4, with the scene and its size."""
POWERS = (1.0, 2.0)
"""Least and largest power of the unknowns that time is taken to grow with; steps are within it."""
FIRST_GROWTH = 1.4
"""That power where one level alone has run."""


@dataclass(frozen=True)
class Cost:
    """What a level costs, or is expected to.

    Attributes:
        unknowns: of the displacement.
        seconds: wall time without the compilation of forms.
        memory: in byte.
    """

    unknowns: int
    seconds: float
    memory: float

    @property
    def words(self) -> str:
        """In words."""
        return f"{self.unknowns:,} unknowns, {duration(self.seconds)}, {self.memory / 1e9:.2g} GB"


def expected(scene: Scene, before: list[Cost]) -> Cost:
    """Cost of a scene.

    Args:
        scene: of a level.
        before: what the levels below it have cost, from the coarsest on.

    Raises:
        SceneError: the scene cannot be run.
    """
    unknowns = size_of(scene).unknowns
    memory = 1e9 * expected_memory(scene, unknowns)
    if not before:
        seconds = SECONDS_PER_UNKNOWN_AND_STEP * unknowns * sum(_steps(piece) for piece in _spans(scene))
        return Cost(unknowns, seconds, memory)
    last = before[-1]
    seconds = last.seconds * (unknowns / last.unknowns) ** _power(before)
    return Cost(unknowns, seconds, max(memory, last.memory))


def _power(before: list[Cost]) -> float:
    """Power of the unknowns that time has grown with."""
    if len(before) < 2:
        return FIRST_GROWTH
    one, two = before[-2:]
    grown = math.log(max(two.seconds, 1e-3) / max(one.seconds, 1e-3)) / math.log(two.unknowns / one.unknowns)
    return min(max(grown, POWERS[0]), POWERS[1])


def _spans(scene: Scene) -> list[tuple[float, StepControl]]:
    """Durations of the pieces of a path in s, with their steps."""
    found, start = [], 0.0
    for end, control in pieces(scene):
        found.append((end - start, control))
        start = end
    return found


def _steps(piece: tuple[float, StepControl]) -> int:
    """Steps of a piece that all go well."""
    left, control = piece
    size, steps = control.first, 0
    while left > 1e-9 * piece[0]:
        left -= min(size, left)
        size, steps = min(size * control.growth, control.largest), steps + 1
    return steps


def duration(seconds: float) -> str:
    """Time in words: a figure or two, in s, minutes or hours."""
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.2g} s" if seconds < 100 else f"{seconds:.0f} s"
