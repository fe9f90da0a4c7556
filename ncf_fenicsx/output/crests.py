"""The highest crest of a surface: its height over the troughs beside it, where it lifts off, and where it is.

Lines of the surface are followed along their nodes, so it may rotate as far as it likes. Plain arrays only.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.output.wrinkles import grid_of

Floats = NDArray[np.float64]

SHARE = 0.1
"""Height of a crest over that of the highest one from which on it is counted."""
APART = 0.5
"""Height of a crest, and depth of the dip before it, over another's height, from which on it is another wave."""
NEAR, FAR = 0.01 ** (1 / 3), 0.08 ** (1 / 3)
"""Cube roots of the shares of a crest's height between which the face is followed down to where it lifts off.

A sheet leaves its support without slope and without curvature, so its lift grows with the third power of the distance:
the cube root of it is a straight line. Below one per cent what is under the sheet springs back, and hides that.
"""


@dataclass(frozen=True)
class Crest:
    """The highest crest of a surface.

    Attributes:
        height: over the higher of the troughs on its two sides in m; 0 without a crest.
        lift: of the crest over where it would lie undeformed in m; 0 without one.
        length: distance in plan in m between the two places where the surface lifts off; 0 without a crest.
        x: where it is now in m; 0 without one.
        y: the same.
        count: crests on its line that have a tenth of its height or more.
    """

    height: float = 0.0
    lift: float = 0.0
    length: float = 0.0
    x: float = 0.0
    y: float = 0.0
    count: int = 0


@dataclass(frozen=True)
class _Line:
    """A line of nodes: coordinates along it, lift, and places undeformed and now, in m; rows of places are x and y."""

    along: Floats
    lift: Floats
    undeformed: Floats
    now: Floats

    def place(self, along: float) -> Floats:
        """Place now in m of an undeformed coordinate."""
        return np.array([np.interp(along, self.along, row) for row in self.now])


@dataclass(frozen=True)
class _Peak:
    """A node higher than its neighbours, nodes of the troughs on its two sides, and how many such there are."""

    line: _Line
    node: int
    troughs: tuple[int, int]
    count: int

    @property
    def height(self) -> float:
        """Over the higher trough in m."""
        return float(self.line.lift[self.node] - self.line.lift[list(self.troughs)].max())


def highest_crest(undeformed: Floats, current: Floats, lift: Floats, model: Floats, floor: float) -> Crest:
    """The crest with the greatest height, on lines along x and y; of equal ones that in the modelled part.

    Args:
        undeformed: positions of the nodes in plan in m, shape (nodes, 2).
        current: the same now.
        lift: how far each node is over where it would lie undeformed on what carries the stack, in m, shape (nodes,).
        model: lowest and highest undeformed x and y in m of the modelled part, shape (2, 2).
        floor: height in m below which there is no crest.
    """
    peaks = [peak for line in _lines(undeformed, current, lift, floor) for peak in _peaks(line, floor)]
    if not peaks:
        return Crest()
    # of crests that differ by rounding only, the same one on any number of ranks
    greatest = (1 - 1e-6) * max(peak.height for peak in peaks)
    equal = [peak for peak in peaks if peak.height >= greatest]
    inside = [peak for peak in equal if _is_inside(peak.line.undeformed[:, peak.node], model)]
    return _measured((inside or equal)[0])


def _is_inside(place: Floats, model: Floats) -> bool:
    """Whether an undeformed place (m) is in the modelled part."""
    slack = 1e-9 * float(np.ptp(model))
    return bool(np.all(place >= model[0] - slack) and np.all(place <= model[1] + slack))


def _lines(undeformed: Floats, current: Floats, lift: Floats, floor: float) -> Iterator[_Line]:
    """Lines along x and y that rise and fall by more than a floor (m)."""
    grid = grid_of(undeformed)
    now = (grid.values(current[:, axis]) for axis in range(2))
    values = np.stack([grid.values(lift), *np.meshgrid(grid.x, grid.y), *now])
    for axis, lines in enumerate((values.transpose(1, 0, 2), values.transpose(2, 0, 1))):
        for line in lines:
            known = line[:, np.isfinite(line[0])]
            if known.size and _highest(known[0]) > floor:
                yield _Line(known[1 + axis], known[0], known[1:3], known[3:])


def _highest(lift: Floats) -> float:
    """Height of a line's nodes over the lowest on either side at most in m, which no crest exceeds."""
    lowest = [np.minimum.accumulate(lift[::way])[::way] for way in (1, -1)]
    return float(np.max(lift - np.maximum(*lowest)))


def _peaks(line: _Line, floor: float) -> list[_Peak]:
    """The crests of a line whose height is above a floor (m)."""
    # half a second to load, for waves only
    from scipy.signal import find_peaks, peak_prominences

    nodes = find_peaks(line.lift)[0]
    heights = peak_prominences(line.lift, nodes)[0]
    count = int(np.count_nonzero(heights >= SHARE * heights.max(initial=floor)))
    peaks = []
    for node, height in zip(nodes, heights, strict=True):
        if height > floor:
            level, high = line.lift[node] - APART * height, nodes[heights >= APART * height]
            apart = [other for other in high if line.lift[min(node, other) : max(node, other) + 1].min() <= level]
            peaks.append(_Peak(line, int(node), _troughs(line.lift, int(node), np.array(apart, dtype=int)), count))
    return peaks


def _troughs(lift: Floats, node: int, others: NDArray[np.int64]) -> tuple[int, int]:
    """Lowest nodes between a crest and the next ones, or the ends of the line; of equal ones that next to the crest."""
    left = int(others[others < node].max(initial=0))
    right = int(others[others > node].min(initial=len(lift) - 1))
    return node - int(np.argmin(lift[left : node + 1][::-1])), node + int(np.argmin(lift[node : right + 1]))


def _measured(peak: _Peak) -> Crest:
    """Crest of the parabola through the nodes around a peak, and where the line lifts off on either side."""
    line, node = peak.line, peak.node
    vertex, lift = _vertex(line.along[node - 1 : node + 2], line.lift[node - 1 : node + 2])
    height = peak.height + lift - float(line.lift[node])
    level = lift - height
    ends = [_lift_off(line, node, trough, level, height) for trough in peak.troughs]
    x, y = line.place(vertex)
    length = float(np.linalg.norm(line.place(ends[1]) - line.place(ends[0])))
    return Crest(height, lift, length, float(x), float(y), peak.count)


def _vertex(along: Floats, lift: Floats) -> tuple[float, float]:
    """Vertex of the parabola through three points with the highest in the middle; the middle one of a plateau."""
    before, after = np.diff(lift) / np.diff(along)
    bend = (after - before) / (along[2] - along[0])
    if not bend < 0:
        return float(along[1]), float(lift[1])
    slope = before + bend * (along[1] - along[0])
    step = -slope / (2 * bend)
    return float(along[1] + step), float(lift[1] + slope * step / 2)


def _lift_off(line: _Line, node: int, trough: int, level: float, height: float) -> float:
    """Undeformed coordinate in m at which a line lifts off between a trough and the node of a crest.

    Args:
        line: of the crest.
        node: of the crest.
        trough: node of the trough.
        level: lift of the higher trough in m.
        height: of the crest over it in m.
    """
    down = np.arange(node, trough + np.sign(trough - node), np.sign(trough - node))
    along, root = line.along[down], np.cbrt(np.maximum(line.lift[down] - level, 0.0) / height)
    near, far, end = (_first_below(along, root, value) for value in (NEAR, FAR, 1e-6))
    straight = near + (near - far) * NEAR / (FAR - NEAR)
    return float(np.clip(straight, min(near, end), max(near, end)))


def _first_below(along: Floats, root: Floats, value: float) -> float:
    """Where a series first falls below a value, which its first one is above of; at its end if nowhere."""
    below = np.flatnonzero(root < value)
    if not len(below):
        return float(along[-1])
    after = int(below[0])
    share = (root[after - 1] - value) / (root[after - 1] - root[after])
    return float(along[after - 1] + share * (along[after] - along[after - 1]))
