"""Open positions between layers, and the extent of a contact. Plain arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

EDGES = np.array([[0, 1], [2, 3], [0, 2], [1, 3]])
"""Edges of a quad with its corners in the order (0,0), (1,0), (0,1), (1,1)."""


@dataclass(frozen=True)
class Voids:
    """Open positions between two layers.

    Attributes:
        volume: integral of the opening in m3.
        longest: largest extent along x or y of one connected void in m, 0 without a void.
        widest_opening: largest opening in m.
    """

    volume: float
    longest: float
    widest_opening: float


def voids(positions: Floats, quads: Integers, gap: Floats, area: Floats, tolerance: float) -> Voids:
    """Measures the open positions of a surface; a void is a set of nodes with a gap, connected by edges.

    Args:
        positions: positions of the nodes in plan in m, shape (nodes, 2).
        quads: nodes at the corners (0,0), (1,0), (0,1), (1,1) of each quad, shape (quads, 4).
        gap: gap at each node in m, negative where closed, shape (nodes,).
        area: each node's share of the area in m2, shape (nodes,).
        tolerance: gap in m from which on a void is one.
    """
    opening = np.maximum(gap, 0.0)
    ends = quads[:, EDGES].reshape(-1, 2)
    inside = gap > tolerance
    joined = ends[inside[ends].all(axis=1)]
    links = coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(len(gap), len(gap)))
    count, void = connected_components(links, directed=False)
    border, inner = _border(positions, ends, gap - tolerance, inside)
    points = np.concatenate([positions[inside], border])
    number = np.concatenate([void[inside], void[inner]])
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, number, points)
    np.maximum.at(high, number, points)
    longest = float((high - low).max(initial=0.0))
    return Voids(float(area @ opening), longest, float(opening.max(initial=0.0)))


def contact_extent(positions: Floats, quads: Integers, gap: Floats) -> tuple[float, float]:
    """Extent in m along x and along y of the zone with a gap of at most 0; zeros without contact.

    Args:
        positions: current positions of the nodes in plan in m, shape (nodes, 2).
        quads: nodes at the corners (0,0), (1,0), (0,1), (1,1) of each quad, shape (quads, 4).
        gap: gap at each node in m, shape (nodes,).
    """
    inside = gap <= 0
    if not inside.any():
        return 0.0, 0.0
    border, _ = _border(positions, quads[:, EDGES].reshape(-1, 2), gap, inside)
    along_x, along_y = np.ptp(np.concatenate([positions[inside], border]), axis=0)
    return float(along_x), float(along_y)


def _border(positions: Floats, ends: Integers, value: Floats, inside: NDArray[np.bool_]) -> tuple[Floats, Integers]:
    """Where a value interpolated on edges passes zero, shape (crossings, 2), and the edge's end inside."""
    cut = ends[inside[ends[:, 0]] != inside[ends[:, 1]]]
    a, b = cut.T
    share = value[a] / (value[a] - value[b])
    return positions[a] + share[:, None] * (positions[b] - positions[a]), np.where(inside[a], a, b)
