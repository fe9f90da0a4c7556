"""Deformed lines of a surface: where one overhangs, where it crosses itself, where it turns most. Plain arrays only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.output.wrinkles import grid_of

Floats = NDArray[np.float64]


class Place(NamedTuple):
    """Where a line is remarkable.

    Attributes:
        position: of the deformed surface in m, shape (3,).
        angle: what it is remarkable for, in rad.
        length: of the line's pieces there in m.
    """

    position: Floats
    angle: float
    length: float


def line_families(undeformed: Floats, current: Floats) -> list[tuple[Floats, int]]:
    """Lines of a surface along x, and along y.

    Args:
        undeformed: positions of its nodes in plan in m, shape (nodes, 2).
        current: their positions now in m, shape (nodes, 3).

    Returns:
        Of each family the positions now in m, nan off the surface, shape (lines, points, 3), and the axis that its
        lines follow undeformed.
    """
    grid = grid_of(undeformed)
    surface = np.stack([grid.values(component) for component in current.T], axis=-1)
    return [(surface, 0), (surface.swapaxes(0, 1), 1)]


def steepest(lines: Floats, axis: int) -> Place | None:
    """Piece with the largest angle between it and its undeformed direction; above pi/2 it overhangs.

    Args:
        lines: positions in m, shape (lines, points, 3).
        axis: that they follow undeformed.
    """
    angle, length = _pieces(lines, axis)
    return _place(np.abs(angle), (lines[:, 1:] + lines[:, :-1]) / 2, length)


def sharpest(lines: Floats, axis: int) -> Place | None:
    """Node where a line turns most from one piece to the next; arguments as above."""
    angle, length = _pieces(lines, axis)
    turn = (np.diff(angle, axis=1) + np.pi) % (2 * np.pi) - np.pi
    return _place(np.abs(turn), lines[:, 1:-1], (length[:, 1:] + length[:, :-1]) / 2)


def crossing(lines: Floats, axis: int) -> Floats | None:
    """Position in m, shape (3,), where a line crosses itself; None where none does; arguments as above.

    A line that nowhere overhangs cannot.
    """
    angle, _ = _pieces(lines, axis)
    overhang = np.nanmax(np.abs(angle), axis=1, initial=0.0) > np.pi / 2
    found = (_own_crossing(line[np.isfinite(line).all(axis=1)], axis) for line in lines[overhang])
    return next((position for position in found if position is not None), None)


def _own_crossing(line: Floats, axis: int) -> Floats | None:
    start, end = line[:-1, [axis, 2]], line[1:, [axis, 2]]
    along = end - start

    def side(points: Floats) -> Floats:
        """On which side of each piece, by row, each point lies, by column."""
        apart = points[None, :] - start[:, None]
        cross: Floats = along[:, None, 0] * apart[..., 1] - along[:, None, 1] * apart[..., 0]
        return cross

    split = side(start) * side(end) < 0
    first, _ = np.nonzero(np.triu(split & split.T, 2))
    if not len(first):
        return None
    middle: Floats = (line[first[0]] + line[first[0] + 1]) / 2
    return middle


def _pieces(lines: Floats, axis: int) -> tuple[Floats, Floats]:
    """Angle in rad and length in m of the pieces of lines, shape (lines, points - 1) each."""
    along, up = np.moveaxis(np.diff(lines[..., [axis, 2]], axis=1), -1, 0)
    return np.arctan2(up, along), np.hypot(along, up)


def _place(angle: Floats, position: Floats, length: Floats) -> Place | None:
    """Where an angle is largest; None where there is none."""
    known = np.where(np.isfinite(angle), angle, -1.0)
    if not known.size or known.max() < 0:
        return None
    at = np.unravel_index(int(np.argmax(known)), known.shape)
    return Place(position[at], float(angle[at]), float(length[at]))
