"""Positions of nodes along an axis that share out an error evenly: pure numpy.

Where a field that varies along x is held by its means in elements of length h(x), the square of its error is the
integral of h^2 g / 12, g being the square of its slope. Of all meshes with N elements, the one with h in proportion
to g^(-1/3) has the smallest error; each of its elements has the same share in it (Babuska and Rheinboldt 1979).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RATIO = 1.3
"""Largest ratio of the lengths of neighbouring elements: that of the graded meshes which results are verified on."""
SAMPLES = 4000
"""Intervals of an axis in which lengths of elements are worked out."""
LARGEST = 0.25
"""Largest length of an element over that of the axis, unless all elements are longer: where nothing varies."""
HALVINGS = 60


def placed(lines: Floats, squares: Floats, count: int) -> Floats:
    """Positions of the nodes of a number of elements, shape (count + 1,).

    Args:
        lines: ends in m of the intervals that the error is known in, shape (intervals + 1,).
        squares: g in each, up to a factor, shape (intervals,).
        count: number of elements.
    """
    points = np.linspace(lines[0], lines[-1], SAMPLES + 1)
    ideal = _ideal(lines, squares, points)
    shortest, longest = 1e-6, 1e6  # times the ideal lengths of one element all along the axis
    for _ in range(HALVINGS):
        scale = math.sqrt(shortest * longest)
        number = _numbers(points, _grown(points, scale * ideal))[-1]
        shortest, longest = (scale, longest) if number > count else (shortest, scale)
    return _nodes(points, _grown(points, longest * ideal), count)


def with_lengths(points: Floats, lengths: Floats) -> Floats:
    """Positions of the nodes of elements no longer than wanted, which grow from one to the next no faster than allowed.

    Args:
        points: ends in m of many even intervals along the axis, shape (intervals + 1,).
        lengths: of elements that are wanted in each in m, shape (intervals,).
    """
    allowed = _grown(points, lengths)
    return _nodes(points, allowed, math.ceil(_numbers(points, allowed)[-1] - 1e-9))


def _nodes(points: Floats, lengths: Floats, count: int) -> Floats:
    numbers = _numbers(points, lengths)
    positions: Floats = np.interp(np.linspace(0.0, numbers[-1], count + 1), numbers, points)
    positions[[0, -1]] = points[[0, -1]]
    return positions


def constant_of(lines: Floats, squares: Floats) -> float:
    """Root mean square error times the number of elements, of the ideal mesh, for the integral of squares being g's."""
    return float((np.cbrt(squares) @ np.diff(lines)) ** 1.5 / math.sqrt(12))


def error_of(lines: Floats, squares: Floats, positions: Floats) -> float:
    """Root mean square error of a mesh, for the integral of squares being g's: of elements that are small to them.

    Args:
        lines: ends in m of the intervals that g is known in.
        squares: g in each.
        positions: of the mesh's nodes in m.
    """
    points = np.union1d(lines, positions)
    middles, parts = (points[1:] + points[:-1]) / 2, np.diff(points)
    lengths = np.diff(positions)[np.searchsorted(positions, middles) - 1]
    g = squares[np.searchsorted(lines, middles) - 1]
    return float(np.sqrt(parts @ (g * lengths**2) / 12))


def cheapest(constants: tuple[float, float], error: float) -> tuple[int, int]:
    """Numbers of elements along x and along y, whose product is the least that has an error.

    Args:
        constants: root mean square error times the number of elements, along x and along y.
        error: root mean square that both may have together.
    """
    along_x, along_y = constants
    fewest = math.floor(along_y / error) + 1
    y = np.arange(fewest, 4 * fewest + 1)
    x = np.maximum(np.ceil(along_x / np.sqrt(error**2 - (along_y / y) ** 2)), 1)
    best = int(np.argmin(x * y))
    return int(x[best]), int(y[best])


def _ideal(lines: Floats, squares: Floats, points: Floats) -> Floats:
    """Lengths of elements between points, up to a factor: over the whole axis there is one of them."""
    middles = (points[1:] + points[:-1]) / 2
    density = np.cbrt(squares)[np.searchsorted(lines, middles) - 1]
    density = np.maximum(density, 1e-6 * density.max()) if density.any() else np.ones_like(density)
    lengths: Floats = density @ np.diff(points) / density
    return lengths


def _grown(points: Floats, lengths: Floats) -> Floats:
    """Lengths of elements that grow from one to the next no faster than `RATIO`, none above `LARGEST` times the axis.

    Args:
        points: ends of intervals in m, shape (intervals + 1,).
        lengths: that are wanted in each in m, shape (intervals,).
    """
    cap = max(LARGEST * float(points[-1] - points[0]), float(lengths.min()))
    limited = np.minimum(lengths, cap)
    rise = math.log(RATIO) * (points[1:] + points[:-1]) / 2
    forwards = rise + np.minimum.accumulate(limited - rise)
    backwards = np.minimum.accumulate((limited + rise)[::-1])[::-1] - rise
    return np.minimum(forwards, backwards)


def _numbers(points: Floats, lengths: Floats) -> Floats:
    """Number of elements from the first point to each, shape (points,)."""
    return np.concatenate([[0.0], np.cumsum(np.diff(points) / lengths)])
