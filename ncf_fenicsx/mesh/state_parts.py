"""Parts of a committed state: what a checkpoint keeps, and how it is read and written back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Place(Enum):
    """Where the values of a part stand."""

    NODES = "nodes"
    CELLS = "cells"
    EVERYWHERE = "everywhere"


@dataclass(frozen=True)
class StatePart:
    """One part of a committed state.

    Attributes:
        place: at this rank's local nodes, or cells; or shared by all ranks.
        read: the values, those of a node or cell together.
        write: takes them back, one row for each node or cell.
    """

    place: Place
    read: Callable[[], Floats]
    write: Callable[[Floats], None]


def under(prefix: str, parts: dict[str, StatePart]) -> dict[str, StatePart]:
    """The parts with a prefix before their names."""
    return {f"{prefix}.{name}": part for name, part in parts.items()}
