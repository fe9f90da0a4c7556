"""What two inputs do together: main effects of one for each level of another; parallel where they do not interact."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.sweeps.effects import Effect, effect
from ncf_fenicsx.sweeps.inputs import Input, Point, number_of
from ncf_fenicsx.sweeps.samples import Samples

MOST_PAIRS = 15
"""Pairs of inputs that are looked at."""
MOST_GROUPS = 6
"""Different values of an input up to which each is a group of its own."""


@dataclass(frozen=True)
class Interaction:
    """Main effects of an input on a result.

    Attributes:
        first: the input.
        second: the other one.
        effects: of the first, by the level of the second.
    """

    first: Input
    second: Input
    effects: dict[str, Effect]


def interactions(inputs: list[Input], samples: Samples, heading: str) -> list[Interaction]:
    """What pairs of inputs do together to a result, of the first `MOST_PAIRS` pairs."""
    parts, values = samples.of(inputs), samples.values[heading]
    found = []
    for first, second in list(combinations(range(len(inputs)), 2))[:MOST_PAIRS]:
        lines = {}
        for label, chosen in _groups(parts[second]):
            own = [level for level, so in zip(parts[first], chosen, strict=True) if so]
            if np.isfinite(values[chosen]).any():
                lines[label] = effect(inputs[first], own, values[chosen])
        found.append(Interaction(inputs[first], inputs[second], lines))
    return found


def _groups(levels: list[Point]) -> list[tuple[str, NDArray[np.bool_]]]:
    """Runs of each value of an input, or of its lower and upper half where it has many."""
    different = sorted(set(levels), key=lambda level: (number_of(level[0]), level))
    if len(different) <= MOST_GROUPS:
        return [(", ".join(value), np.array([level == value for level in levels])) for value in different]
    numbers = np.array([number_of(level[0]) for level in levels])
    middle = float(np.median(numbers))
    return [(f"up to {middle:.4g}", numbers <= middle), (f"above {middle:.4g}", numbers > middle)]
