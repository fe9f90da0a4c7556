"""Layers on layers: one-sided, frictionless contact of facing nodes, with stitching springs in opening."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import fem, la
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.scene_errors import SceneError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True)
class PairedContact:
    """Contact between the nodes of facing layers, pair by pair.

    The energy of a pair is a k g^2 / 2, with g = n . (x_upper - x_lower) its gap, a the reference area of the lower
    node, and k the penalty where the gap is closed, the stitching stiffness where it is open. The normals are those of
    the lower face in the last accepted step, so that slip along an inclined face opens no gap.

    Attributes:
        nodes: local numbers of the lower and the upper node, shape (pairs, 2).
        initial_distance: x_upper - x_lower of the reference configuration in m, shape (pairs, 3).
        penalty: contact stiffness in Pa/m.
        stitching: stiffness in opening in Pa/m.
    """

    nodes: Integers
    initial_distance: Floats
    penalty: float
    stitching: float

    def gap(self, displacement: Floats, normal: Floats) -> Floats:
        """Opening of each pair along its normal in m, negative in penetration.

        Args:
            displacement: of all local nodes in m, shape (nodes, 3).
            normal: unit normals of the pairs, shape (pairs, 3).
        """
        lower, upper = self.nodes.T
        return np.einsum("ij,ij->i", self.initial_distance + displacement[upper] - displacement[lower], normal)

    def residual(self, displacement: Floats, normal: Floats, area: Floats) -> Floats:
        """Derivative of the energy for the lower and the upper node in N, shape (pairs, 2, 3)."""
        gap = self.gap(displacement, normal)
        upper = (area * self._stiffness(gap) * gap)[:, None] * normal
        return np.stack([-upper, upper], axis=1)

    def tangent(self, displacement: Floats, normal: Floats, area: Floats) -> Floats:
        """Second derivative of the energy in N/m, shape (pairs, 6, 6)."""
        stiffness = area * self._stiffness(self.gap(displacement, normal))
        direction = np.concatenate([-normal, normal], axis=1)
        return stiffness[:, None, None] * direction[:, :, None] * direction[:, None, :]

    def _stiffness(self, gap: Floats) -> Floats:
        return np.where(gap <= 0, self.penalty, self.stitching)


class LayerContact:
    """Contact of the facing layers of a mesh.

    Args:
        displacement: field in m.
        pairs: the facing nodes of this rank.
        area_form: compiled linear form of the lower faces' current normal times area, at nodes.
    """

    def __init__(self, displacement: Any, pairs: PairedContact, area_form: Any) -> None:
        self.displacement, self.pairs, self._area_form = displacement, pairs, area_form
        self.nodes = pairs.nodes
        self._area = np.linalg.norm(self._area_vectors(), axis=1)
        self.update_normals()

    def update_normals(self) -> None:
        """Take the normals of the present configuration."""
        vectors = self._area_vectors()
        self._normal = vectors / np.linalg.norm(vectors, axis=1)[:, None]

    def gap(self) -> Floats:
        """Opening of this rank's pairs in m, negative in penetration."""
        return self.pairs.gap(self._nodal_displacement(), self._normal)

    def residual(self) -> Floats:
        """Residual of this rank's pairs in N, shape (pairs, 2, 3)."""
        return self.pairs.residual(self._nodal_displacement(), self._normal, self._area)

    def tangent(self) -> Floats:
        """Tangent of this rank's pairs in N/m, shape (pairs, 6, 6)."""
        return self.pairs.tangent(self._nodal_displacement(), self._normal, self._area)

    def _nodal_displacement(self) -> Floats:
        return self.displacement.x.array.reshape(-1, 3)

    def _area_vectors(self) -> Floats:
        """Current normal times area of each pair's lower node in m2, shape (pairs, 3)."""
        vector = fem.assemble_vector(self._area_form)
        vector.scatter_reverse(la.InsertMode.add)
        vector.scatter_forward()
        return vector.array.reshape(-1, 3)[self.nodes[:, 0]]


def face_nodes(space: Any, facets: Any) -> Integers:
    """Local nodes of facets."""
    return fem.locate_dofs_topological(space, 2, facets)


def pair_nodes(space: Any, stack: StackMesh) -> Integers:
    """Local nodes (lower, upper) that face each other across interfaces, shape (pairs, 2).

    Each pair stands on the rank that owns its lower node; since ranks hold whole columns, the upper one is there too.

    Raises:
        SceneError: a node has no partner.
    """
    lower, upper = (face_nodes(space, stack.facets(name)) for name in ("lower", "upper"))
    lower = lower[lower < space.dofmap.index_map.size_local]
    x = space.tabulate_dof_coordinates()
    distance, partner = cKDTree(x[upper]).query(x[lower]) if len(upper) else (np.zeros(0), np.zeros(0, dtype=int))
    comm = stack.mesh.comm
    found = comm.allreduce(int(np.count_nonzero(distance <= 1e-6 * stack.extent)))
    if found != stack.interface_nodes:
        raise SceneError(
            f"mesh: {found} of {stack.interface_nodes} nodes between layers have partners; expected columns along z"
        )
    return np.stack([lower, upper[partner]], axis=1).astype(np.int32)
