"""Lines of a grid told from coordinates that round-off has spread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SPREAD = 1e-7
"""Distance, over the extent of a stack, up to which two coordinates that follow each other are of one line."""


def grid_lines(coordinates: Floats, extent: float) -> tuple[Floats, Integers]:
    """Lines that coordinates lie on, ascending, and the number of the line of each.

    Rounded to some digits, coordinates of one line that are near a half of the last digit would be taken for two lines:
    on graded meshes of round numbers they often are.

    Args:
        coordinates: in m, of any points.
        extent: of the stack in m.
    """
    order = np.argsort(coordinates, kind="stable")
    ascending = coordinates[order]
    begins = np.append(True, np.diff(ascending) > SPREAD * extent)
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.cumsum(begins) - 1
    return ascending[begins], number


def places(points: Floats, extent: float) -> Integers:
    """Number of the place of each point: the same for points on one line along each axis.

    Args:
        points: coordinates in m, shape (points, axes).
        extent: of the stack in m.
    """
    numbers = np.stack([grid_lines(along, extent)[1] for along in points.T], axis=1)
    return np.asarray(np.unique(numbers, axis=0, return_inverse=True)[1], dtype=np.int64).ravel()
