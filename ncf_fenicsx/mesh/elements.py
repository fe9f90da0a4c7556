"""Elements of a layer: linear through it, of order 1 or 2 in its plane. Nodes, rules of integration, pieces.

Nodes are numbered as DOLFINx does: vertices, then middles of edges, then middles of faces. Contact and mortar need
positive weights of nodes: a face of nine nodes has those of Simpson's rule, one of eight has not.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import basix
import basix.ufl
import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.hexahedra import FACES

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

CELL = basix.CellType.hexahedron


@dataclass(frozen=True)
class Element:
    """Hexahedra of an order in the plane of a layer; their geometry is trilinear.

    Attributes:
        order: 1 (eight nodes) or 2 (eighteen nodes, nine on the lower face and nine on the upper one).
    """

    order: int

    @cached_property
    def nodes(self) -> Floats:
        """Reference positions, shape (nodes, 3)."""
        return np.array([middle for _, _, middle in self._bearers()])

    def _bearers(self) -> list[tuple[int, int, Floats]]:
        """Dimension, number and middle of each vertex, edge and face that bears a node: those within a level."""
        vertices, topology = basix.geometry(CELL), basix.topology(CELL)
        entities = [
            (dimension, number, vertices[entity].mean(axis=0))
            for dimension in range(1 if self.order == 1 else 3)
            for number, entity in enumerate(topology[dimension])
        ]
        return [entity for entity in entities if entity[2][2] in (0.0, 1.0)]

    @property
    def has_bare_entities(self) -> bool:
        """Whether some edges and faces bear no node where others do, which DOLFINx does not expect."""
        return self.order > 1

    @cached_property
    def vertices(self) -> Integers:
        """Four vertices of the cell, some of them twice, that each node is in the middle of, shape (nodes, 4)."""
        ends = [np.where(self.nodes == 0.5, side, self.nodes) for side in np.ndindex(2, 2, 1)]
        return np.stack([end.astype(np.int64) @ [1, 2, 4] for end in ends], axis=1)

    @cached_property
    def faces(self) -> Integers:
        """Nodes of each face of a cell, x fastest, shape (6, nodes); -1 on upright faces of order 2: none touches."""
        if self.order == 1:
            return FACES
        faces = np.full((6, 9), -1)
        faces[0], faces[5] = (self._level(height) for height in (0.0, 1.0))
        return faces

    def _level(self, height: float) -> Integers:
        """Nodes of the lower or upper face, x fastest."""
        level = np.flatnonzero(self.nodes[:, 2] == height)
        x, y, _ = self.nodes[level].T
        return level[np.lexsort((x, y))]

    @cached_property
    def hexahedra(self) -> Integers:
        """Pieces of a cell with its nodes as corners, shape (pieces, 8)."""
        return np.concatenate([sub_quads(self._level(height)[None]) for height in (0.0, 1.0)], axis=1)

    @cached_property
    def volume_rule(self) -> tuple[Floats, Floats]:
        """Gauss points (points, 3) and weights: two through the layer, and enough in its plane for undeformed cells."""
        return _through_layer(*self._plane_rule)

    @cached_property
    def mid_plane_rule(self) -> tuple[Floats, Floats]:
        """Points (points, 3) and weights on the mid-plane, which stands for the element's thickness."""
        return _on_mid_plane(*self._plane_rule)

    @cached_property
    def reduced_mid_plane_rule(self) -> tuple[Floats, Floats]:
        """Points (points, 3) and weights on the mid-plane, order^2 of them.

        As many points as in `volume_rule` would set more conditions on a volume that hardly changes, or a membrane that
        hardly stretches, than an element has nodes of its own, and it would lock. These are an order lower in each
        direction (Malkus and Hughes 1978).
        """
        return _on_mid_plane(*self._reduced_plane_rule)

    def shear_rule(self, axis: int) -> tuple[Floats, Floats]:
        """Points (points, 3) and weights of `volume_rule` with one less along an axis in the plane, 0 or 1.

        An element that bends along an axis has transverse shear along it that only these points do not see.
        """
        few, many = (
            basix.make_quadrature(basix.CellType.interval, 2 * order - 1) for order in (self.order, self.order + 1)
        )
        (x, along_x), (y, along_y) = (few, many) if axis == 0 else (many, few)
        plane = np.array([[*p, *q] for p in x for q in y])
        return _through_layer(plane, np.outer(along_x, along_y).ravel())

    @property
    def face_rule(self) -> dict[str, Any]:
        """UFL metadata of the rule whose points are the nodes of a face, each with its share of it."""
        return {"quadrature_rule": "vertex" if self.order == 1 else "GLL", "quadrature_degree": self.order}

    @property
    def own_pressure_place(self) -> float:
        """Where a node's contact reads the layer's own pressure: between the node (0) and its element's middle (1).

        Contact acts at the nodes of a face, stress between them. Of a stress that is linear along an element, the
        pressure at two thirds does the same work at the nodes; that at a node does three times as much, and a layer
        would push itself off a tool. With order 2 no place is right for all: at one half the excess is least.
        """
        return 2 / 3 if self.order == 1 else 1 / 2

    @property
    def _plane_rule(self) -> tuple[Floats, Floats]:
        return basix.make_quadrature(basix.CellType.quadrilateral, 2 * self.order)

    @property
    def _reduced_plane_rule(self) -> tuple[Floats, Floats]:
        return basix.make_quadrature(basix.CellType.quadrilateral, 2 * self.order - 1)

    def basix(self, discontinuous: bool = False) -> Any:
        """The scalar element; a discontinuous one shares no node with its neighbours."""
        if self.order == 1:
            return basix.ufl.element("Lagrange", CELL, 1, discontinuous=discontinuous)
        points: list[list[Floats]] = [[np.zeros((0, 3)) for _ in entities] for entities in basix.topology(CELL)]
        if discontinuous:
            points[3] = [self.nodes]
        else:
            for dimension, number, middle in self._bearers():
                points[dimension][number] = middle[None]
        values = [[np.eye(len(at)).reshape(len(at), 1, len(at), 1) for at in row] for row in points]
        # of the 27 products of three polynomials in x, y and z, the 18 without the last one in z
        span = np.eye(27)[np.arange(27) % 3 < 2]
        maps, space = basix.MapType.identity, basix.SobolevSpace.L2 if discontinuous else basix.SobolevSpace.H1
        return basix.ufl.custom_element(CELL, [], span, points, values, 0, maps, space, discontinuous, 1, 2)


def _on_mid_plane(plane: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Points (points, 3) and weights of a rule in the plane of a layer, half-way through it."""
    return np.column_stack([plane, np.full(len(plane), 0.5)]), weights


def _through_layer(plane: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Points (points, 3) and weights of a rule in the plane of a layer, at the two Gauss points through it."""
    height, shares = basix.make_quadrature(basix.CellType.interval, 2)
    return np.array([[*point, *z] for point in plane for z in height]), np.outer(weights, shares).ravel()


def sub_quads(elements: Integers) -> Integers:
    """Quadrilaterals between neighbouring nodes of faces; both x fastest.

    Args:
        elements: nodes of each face, shape (faces, 4) or (faces, 9).

    Returns:
        Shape (quadrilaterals, 4), those of a face together.
    """
    along = round(elements.shape[1] ** 0.5)
    grid = np.arange(along * along).reshape(along, along)
    corners = [grid[j : j + along - 1, i : i + along - 1].ravel() for j, i in np.ndindex(2, 2)]
    quads: Integers = elements[:, np.stack(corners, axis=1)].reshape(-1, 4)
    return quads
