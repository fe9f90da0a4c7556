"""Waves of a surface: its lines along x and y, their wavelength, height and slope. Plain arrays only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FLOOR = 1e-9
"""Amplitude in m below which a line counts as flat."""
BAND = 0.05
"""Kind of a line's amplitude that its deflection has to reach on the other side of its mean for a crossing to count."""
PADDING = 8
"""Length of the series that the spectrum is taken of, filled up with zeros, over that of the line."""
NEIGHBOURS = 16
"""Nodes that a value is fitted to where nodes form no grid; a quadratic has six coefficients."""
REACH = 3.0
"""Sum of the sizes of a fit's weights above which it extrapolates: up to about 2 on a surface, growing away from it."""


@dataclass(frozen=True)
class Wrinkles:
    """Waves of a surface along lines parallel to x and to y; all zero for a flat one.

    Attributes:
        amplitude: half the difference between highest and lowest deflection in m.
        wavelength: ``crossing_wavelength`` of the line with the largest amplitude in m, 0 without a wave.
        misalignment: largest angle between a deformed line and its undeformed direction in rad; above pi/2 where the
            surface overhangs.
        curvature: largest curvature of a deformed line in 1/m.
    """

    amplitude: float
    wavelength: float
    misalignment: float
    curvature: float


def wrinkles(positions: Floats, displacement: Floats, floor: float = FLOOR) -> Wrinkles:
    """Measures the waves of a surface.

    For w = A sin(2 pi x / l) the misalignment tends to atan(2 pi A / l) and the curvature to A (2 pi / l)^2. The lines
    are those of the nodes if these form a grid, else those of a grid that the displacement is fitted to. They are
    followed along their nodes, so a surface may rotate as far as it likes.

    Args:
        positions: undeformed positions of the nodes in plan in m, shape (nodes, 2).
        displacement: of the nodes in m, shape (nodes, 3).
        floor: lines with a smaller amplitude in m are flat.
    """
    grid = grid_of(positions)
    u, v, w = (grid.values(component) for component in displacement.T)
    along = [_steepest(grid.x + u, w, floor), _steepest((grid.y[:, None] + v).T, w.T, floor)]
    angle, curvature = np.max(along, axis=0)
    wavelength = crossing_wavelength(*_highest_line(grid, w), floor)
    return Wrinkles(float(np.ptp(displacement[:, 2])) / 2, wavelength, float(angle), float(curvature))


@dataclass(frozen=True)
class Grid:
    """Values on grid lines as weighted values of nodes.

    Attributes:
        x: grid coordinates in m.
        y: grid coordinates in m.
        nodes: nodes that a grid point takes its value from, shape (y, x, neighbours).
        weights: their weights, nan off the surface, shape (y, x, neighbours).
    """

    x: Floats
    y: Floats
    nodes: Integers
    weights: Floats

    def values(self, nodal: Floats) -> Floats:
        """Values at the grid points from those of the nodes, nan off the surface, shape (y, x)."""
        return np.einsum("yxn,yxn->yx", self.weights, nodal[self.nodes])


def grid_of(positions: Floats) -> Grid:
    """The grid that nodes form (its spacing may be graded), else a regular one over them of about as many points.

    Args:
        positions: positions of the nodes in plan in m, shape (nodes, 2).
    """
    return _grid(np.asarray(positions, dtype=np.float64).tobytes())


@lru_cache(maxsize=16)
def _grid(positions: bytes) -> Grid:
    """Kept from call to call: undeformed positions stay the same from step to step, and a fit takes a second."""
    points = np.frombuffer(positions).reshape(-1, 2)
    tolerance = 1e-6 * float(np.ptp(points, axis=0).max())
    (x, column), (y, row) = (_numbered(points[:, axis], tolerance) for axis in (0, 1))
    index = row * len(x) + column
    nodes = np.argsort(index)
    if len(x) * len(y) == len(points) and np.array_equal(index[nodes], np.arange(len(points))):
        shape = (len(y), len(x), 1)
        return Grid(x, y, nodes.reshape(shape), np.ones(shape))
    return _fitted_grid(points)


def _numbered(coordinate: Floats, tolerance: float) -> tuple[Floats, Integers]:
    """Distinct coordinates in m, ascending, and the number of each node's."""
    order = np.argsort(coordinate)
    number = np.zeros(len(order), dtype=np.int64)
    number[order[1:]] = np.cumsum(np.diff(coordinate[order]) > tolerance)
    return np.bincount(number, coordinate) / np.bincount(number), number


def _fitted_grid(points: Floats) -> Grid:
    """A regular grid of about as many points, with a quadratic fitted to the nodes around each of them.

    Moving least squares: linear interpolation would not do, its second differences do not converge.
    """
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    counts = np.rint(extent / math.sqrt(extent.prod() / len(points))).astype(int) + 1
    x, y = (start + np.linspace(0.0, length, count) for start, length, count in zip(low, extent, counts, strict=True))
    targets = np.stack(np.meshgrid(x, y), axis=-1)
    distance, nodes = cKDTree(points).query(targets, min(NEIGHBOURS, len(points)))
    radius = distance[..., -1:]
    u, v = np.moveaxis((points[nodes] - targets[:, :, None]) / radius[..., None], -1, 0)
    root = 1 - distance / radius  # of the weight, which falls to 0 at the last node: neighbours change smoothly
    basis = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)
    weights = np.linalg.pinv(root[..., None] * basis, rcond=1e-6)[..., 0, :] * root
    weights[np.abs(weights).sum(axis=-1) > REACH] = np.nan
    return Grid(x, y, nodes, weights)


def crossing_wavelength(position: Floats, deflection: Floats, floor: float = FLOOR) -> float:
    """Twice the mean distance in m between successive crossings of a line with its mean; 0 with fewer than two.

    Crossings are those of noise unless the deflection leaves a band about the mean on the other side.

    Args:
        position: positions along the line in m, ascending, shape (points,).
        deflection: height over the undeformed line in m, nan where unknown, shape (points,).
        floor: a line with a smaller amplitude in m is flat.
    """
    known = np.isfinite(deflection)
    s, w = position[known], deflection[known]
    height = float(np.ptp(w)) / 2 if len(w) else 0.0
    if height <= floor:
        return 0.0
    v = w - np.diff(s) @ (w[1:] + w[:-1]) / (2 * (s[-1] - s[0]))
    above = v > 0
    outside = np.flatnonzero(np.abs(v) > BAND * height)
    arrivals = outside[1:][above[outside[1:]] != above[outside[:-1]]]
    if len(arrivals) < 2:
        return 0.0
    changes = np.flatnonzero(above[1:] != above[:-1])
    before = changes[np.searchsorted(changes, arrivals) - 1]  # of several changes within the band, the last one
    zeros = s[before] + np.diff(s)[before] * v[before] / (v[before] - v[before + 1])
    return 2 * float(zeros[-1] - zeros[0]) / (len(zeros) - 1)


def spectral_wavelength(position: Floats, deflection: Floats, floor: float = FLOOR) -> float:
    """Wavelength in m at the peak of a line's power spectrum (trend removed, Hann window); 0 without a peak.

    The peak is that of a parabola through the logarithm of the power; waves longer than twice the line are no waves.

    Args:
        position: positions along the line in m, ascending, shape (points,).
        deflection: height over the undeformed line in m, shape (points,).
        floor: a line with a smaller amplitude in m is flat.
    """
    points = 2 * len(position)
    s = np.linspace(position[0], position[-1], points)
    height = np.interp(s, position, deflection)
    w = height - np.polynomial.Polynomial.fit(s, height, 1)(s)
    if np.ptp(w) / 2 <= floor:
        return 0.0
    power: Floats = np.abs(np.fft.rfft(w * np.hanning(points), PADDING * points)) ** 2
    first = PADDING // 2
    peak = first + int(np.argmax(power[first : PADDING * points // 4]))
    before, at, after = np.log(power[peak - 1 : peak + 2])
    if at < max(before, after):
        return 0.0
    shift = (before - after) / (2 * (before - 2 * at + after))
    return float(PADDING * points * (s[1] - s[0]) / (peak + shift))


def _steepest(position: Floats, w: Floats, floor: float) -> tuple[float, float]:
    """Largest angle (rad) of segments of lines that are not flat, and curvature (1/m): what two of them turn by."""
    high = _amplitudes(w) > floor
    along, up = np.diff(position[high], axis=1), np.diff(w[high], axis=1)
    angle, length = np.arctan2(up, along), np.hypot(along, up)
    turn = (np.diff(angle, axis=1) + np.pi) % (2 * np.pi) - np.pi
    return _largest(angle), _largest(2 * turn / (length[:, 1:] + length[:, :-1]))


def _largest(values: Floats) -> float:
    return float(np.fmax.reduce(np.abs(values), axis=None, initial=0.0))


def _amplitudes(w: Floats) -> Floats:
    return (np.fmax.reduce(w, axis=1) - np.fmin.reduce(w, axis=1)) / 2


def _highest_line(grid: Grid, w: Floats) -> tuple[Floats, Floats]:
    heights = np.concatenate([_amplitudes(w), _amplitudes(w.T)])
    # the first of lines that differ by rounding only, so that the choice is the same on any number of ranks
    best = int(np.argmax(heights >= (1 - 1e-6) * _largest(heights)))
    return (grid.x, w[best]) if best < len(w) else (grid.y, w[:, best - len(w)])
