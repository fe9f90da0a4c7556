"""Elements of a face in plan: their quadrilaterals, shape functions and overlaps with those of another face.

An element of four nodes is a quadrilateral, one of nine nodes is four: these tell what lies where. No DOLFINx here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import basix
import numpy as np
import shapely
from numpy.typing import NDArray

from ncf_fenicsx.mesh.elements import sub_quads

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RING = np.array([0, 1, 3, 2])
POINTS, POINT_WEIGHTS = basix.make_quadrature(basix.CellType.triangle, 4)
MORE_POINTS, MORE_POINT_WEIGHTS = basix.make_quadrature(basix.CellType.triangle, 8)
LEAST_PIECE = 1e-10  # overlaps below this part of a quadrilateral are lines


@dataclass(frozen=True)
class PlanElements:
    """Some elements of a face.

    Attributes:
        positions: nodes of the face in plan in m, shape (nodes, 2).
        nodes: of each element, x fastest, shape (elements, 4 or 9).
    """

    positions: Floats
    nodes: Integers

    @property
    def order(self) -> int:
        """Of the shape functions."""
        return round(self.nodes.shape[1] ** 0.5) - 1

    @property
    def pieces(self) -> int:
        """Quadrilaterals of an element."""
        return self.order**2

    @cached_property
    def quads(self) -> Floats:
        """Corners of the quadrilaterals in m, those of an element together, shape (quadrilaterals, 4, 2)."""
        corners: Floats = self.positions[sub_quads(self.nodes)]
        return corners

    @cached_property
    def polygons(self) -> NDArray[np.object_]:
        """The quadrilaterals as shapes."""
        return np.asarray(shapely.polygons(self.quads[:, RING]) if len(self.quads) else [], dtype=object)

    @cached_property
    def shares(self) -> Floats:
        """Integral of each shape function in m2, shape (elements, nodes)."""
        quads = self.quads
        along_x, along_y = (
            quads[:, [1, 1, 3, 3]] - quads[:, [0, 0, 2, 2]],
            quads[:, [2, 3, 2, 3]] - quads[:, [0, 1, 0, 1]],
        )
        jacobians = cross(along_x, along_y).reshape(len(self.nodes), self.pieces, 4)
        return np.abs(np.einsum("epc,pcn->en", jacobians, _moments(self.order)))

    def some(self, which: NDArray[np.bool_] | Integers | slice) -> PlanElements:
        """Some of the elements."""
        return PlanElements(self.positions, self.nodes[which])

    def in_pieces(self) -> PlanElements:
        """Their quadrilaterals as elements of four nodes."""
        return PlanElements(self.positions, sub_quads(self.nodes))

    def shapes(self, points: Floats, quad: Integers) -> Floats:
        """Shape functions at points (n, p, 2) in each of some quadrilaterals (n,), shape (n, p, nodes)."""
        return _products(self.order, quad % self.pieces, _local(points, self.quads[quad]))


def _products(order: int, piece: Integers, local: Floats) -> Floats:
    """Shape functions at coordinates (n, p, 2) within pieces (n,) of the element, shape (n, p, nodes)."""
    first = np.stack([piece % order, piece // order], axis=-1)
    x, y = np.moveaxis((local + first[:, None]) / order, -1, 0)
    along_x, along_y = _lagrange(order, x), _lagrange(order, y)
    products: Floats = along_y[..., :, None] * along_x[..., None, :]
    return products.reshape(*x.shape, (order + 1) ** 2)


def _lagrange(order: int, x: Floats) -> Floats:
    """Polynomials on [0, 1] that are one at one of ``order`` + 1 even points and zero at the others; on a last axis."""
    if order == 1:
        return np.stack([1 - x, x], axis=-1)
    return np.stack([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)], axis=-1)


@lru_cache
def _moments(order: int) -> Floats:
    """Integrals of shape functions times the bilinear function of each corner of a piece, (pieces, 4, nodes)."""
    points, weights = basix.make_quadrature(basix.CellType.quadrilateral, order + 2)
    piece = np.arange(order * order)
    local = np.broadcast_to(points, (len(piece), *points.shape))
    corner = _products(1, np.zeros_like(piece), local)
    moments: Floats = np.einsum("q,pqc,pqn->pcn", weights, corner, _products(order, piece, local))
    return moments


def _local(points: Floats, quads: Floats) -> Floats:
    """Coordinates on the unit square of points (n, p, 2) in quads (n, 4, 2)."""
    origin, along_x, along_y = quads[:, :1], quads[:, 1:2] - quads[:, :1], quads[:, 2:3] - quads[:, :1]
    twist = quads[:, 3:] - quads[:, 2:3] - along_x
    s = np.full(points.shape, 0.5)
    for _ in range(20):
        d_x, d_y = along_x + s[..., 1:] * twist, along_y + s[..., :1] * twist
        gap = points - origin - s[..., :1] * along_x - s[..., 1:] * d_y
        step = np.stack([cross(gap, d_y), cross(d_x, gap)], axis=-1) / cross(d_x, d_y)[..., None]
        s += step
        if np.abs(step).max(initial=0.0) < 1e-7:  # the next step would be its square
            break
    return s


@dataclass(frozen=True)
class Overlaps:
    """Where quadrilaterals of two faces overlap.

    Attributes:
        quad: of the one face, shape (overlaps,).
        other: of the other face.
        polygons: what they share.
    """

    quad: Integers
    other: Integers
    polygons: NDArray[np.object_]

    @classmethod
    def of(cls, elements: PlanElements, tree: shapely.STRtree) -> Overlaps:
        """Overlaps of elements with the quadrilaterals of another face in a search tree."""
        quad, other = tree.query(elements.polygons)
        shared = shapely.intersection(elements.polygons[quad], tree.geometries[other])
        polygons, pair = shapely.get_parts(shared, return_index=True)
        kept = shapely.area(polygons) > LEAST_PIECE * shapely.area(elements.polygons[quad[pair]])
        return cls(quad[pair[kept]], other[pair[kept]], polygons[kept])

    def points(self, order: int) -> tuple[Floats, Floats, Integers]:
        """Points of integration (triangles, p, 2) in m, their weights (triangles, p) in m2, and each one's overlap."""
        reference, shares = (POINTS, POINT_WEIGHTS) if order == 1 else (MORE_POINTS, MORE_POINT_WEIGHTS)
        triangles, overlap = _triangles(self.polygons)
        twice = np.abs(cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
        points = np.concatenate([1 - reference.sum(axis=1, keepdims=True), reference], axis=1) @ triangles
        return points, twice[:, None] * shares, overlap


def _triangles(polygons: NDArray[np.object_]) -> tuple[Floats, Integers]:
    """Fans of triangles about the first corner of convex polygons, shape (triangles, 3, 2), and their polygons."""
    points, piece = shapely.get_coordinates(polygons, return_index=True)
    # rings end where they start: n corners are n + 1 points, and n - 2 of these have three more of their ring behind
    before = np.flatnonzero(piece[:-3] == piece[3:])
    first = np.searchsorted(piece, piece[before])
    return points[np.stack([first, before + 1, before + 2], axis=1)], piece[before]


def cross(a: Floats, b: Floats) -> Floats:
    """Product of the vectors on the last axis, across the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
