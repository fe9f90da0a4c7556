"""What is measured of a deformed surface between two layers: wrinkles, voids, extent of contact. Plain arrays only."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ncf_fenicsx.output.surface_lines import FLOOR, Grid, crossing_wavelength, grid_of

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

EDGES = np.array([[0, 1], [2, 3], [0, 2], [1, 3]])
"""Edges of a quad with its corners in the order (0,0), (1,0), (0,1), (1,1)."""


@dataclass(frozen=True)
class Wrinkles:
    """Waves of a surface along lines parallel to x and to y; all zero for a flat one.

    Attributes:
        amplitude: half the difference between highest and lowest deflection in m.
        wavelength: ``crossing_wavelength`` of the line with the largest amplitude in m, 0 without a wave.
        misalignment: largest angle between a line and its undeformed direction in rad.
        curvature: largest second derivative of the deflection along a line in 1/m.
    """

    amplitude: float
    wavelength: float
    misalignment: float
    curvature: float


@dataclass(frozen=True)
class Voids:
    """Open places between two layers.

    Attributes:
        volume: integral of the opening in m3.
        longest: largest extent along x or y of one connected void in m, 0 without a void.
        widest_opening: largest opening in m.
    """

    volume: float
    longest: float
    widest_opening: float


def wrinkles(places: Floats, deflection: Floats, floor: float = FLOOR) -> Wrinkles:
    """Measures the waves of a surface.

    For w = A sin(2 pi x / l) the misalignment tends to atan(2 pi A / l) and the curvature to A (2 pi / l)^2. The lines
    are those of the nodes if these form a grid, else those of a grid that the deflection is fitted to.

    Args:
        places: undeformed places of the nodes in plan in m, shape (nodes, 2).
        deflection: height now minus height undeformed in m, shape (nodes,).
        floor: lines with a smaller amplitude in m are flat.
    """
    grid = grid_of(places)
    w = grid.values(deflection)
    along = [_steepest(grid.x, w, floor), _steepest(grid.y, w.T, floor)]
    slope, curvature = np.max(along, axis=0)
    wavelength = crossing_wavelength(*_highest_line(grid, w), floor)
    return Wrinkles(float(np.ptp(deflection)) / 2, wavelength, math.atan(slope), float(curvature))


def voids(places: Floats, quads: Integers, gap: Floats, area: Floats, tolerance: float) -> Voids:
    """Measures the open places of a surface; a void is a set of nodes with a gap, connected by edges.

    Args:
        places: places of the nodes in plan in m, shape (nodes, 2).
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
    border, inner = _border(places, ends, gap - tolerance, inside)
    points = np.concatenate([places[inside], border])
    number = np.concatenate([void[inside], void[inner]])
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, number, points)
    np.maximum.at(high, number, points)
    longest = float((high - low).max(initial=0.0))
    return Voids(float(area @ opening), longest, float(opening.max(initial=0.0)))


def contact_extent(places: Floats, quads: Integers, gap: Floats) -> tuple[float, float]:
    """Extent in m along x and along y of the zone with a gap of at most 0; zeros without contact.

    Args:
        places: current places of the nodes in plan in m, shape (nodes, 2).
        quads: nodes at the corners (0,0), (1,0), (0,1), (1,1) of each quad, shape (quads, 4).
        gap: gap at each node in m, shape (nodes,).
    """
    inside = gap <= 0
    if not inside.any():
        return 0.0, 0.0
    border, _ = _border(places, quads[:, EDGES].reshape(-1, 2), gap, inside)
    along_x, along_y = np.ptp(np.concatenate([places[inside], border]), axis=0)
    return float(along_x), float(along_y)


def _border(places: Floats, ends: Integers, value: Floats, inside: NDArray[np.bool_]) -> tuple[Floats, Integers]:
    """Where a value interpolated on edges passes zero, shape (crossings, 2), and the edge's end inside."""
    cut = ends[inside[ends[:, 0]] != inside[ends[:, 1]]]
    a, b = cut.T
    share = value[a] / (value[a] - value[b])
    return places[a] + share[:, None] * (places[b] - places[a]), np.where(inside[a], a, b)


def _steepest(position: Floats, w: Floats, floor: float) -> tuple[float, float]:
    """Largest slope of segments and second derivative (1/m, three points) of lines that are not flat."""
    lines, steps = w[_amplitudes(w) > floor], np.diff(position)
    slope = np.diff(lines, axis=1) / steps
    second = 2 * np.diff(slope, axis=1) / (steps[1:] + steps[:-1])
    return _largest(slope), _largest(second)


def _largest(values: Floats) -> float:
    return float(np.fmax.reduce(np.abs(values), axis=None, initial=0.0))


def _amplitudes(w: Floats) -> Floats:
    return (np.fmax.reduce(w, axis=1) - np.fmin.reduce(w, axis=1)) / 2


def _highest_line(grid: Grid, w: Floats) -> tuple[Floats, Floats]:
    heights = np.concatenate([_amplitudes(w), _amplitudes(w.T)])
    # the first of lines that differ by rounding only, so that the choice is the same on any number of ranks
    best = int(np.argmax(heights >= (1 - 1e-6) * _largest(heights)))
    return (grid.x, w[best]) if best < len(w) else (grid.y, w[:, best - len(w)])
