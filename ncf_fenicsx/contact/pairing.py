"""Which nodes of the upper faces each lower node faces, and with what weight; follows slip, over all ranks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, csr_matrix
from scipy.spatial import cKDTree

from ncf_fenicsx.contact import mortar
from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.mesh.faces import NodalSpaces, SharedFace
from ncf_fenicsx.mesh.hexahedra import lower_tag, upper_tag

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SNAP = 0.05
"""Slip up to which a node stays with the partner it started on, relative to the shortest edge between nodes there.

Along the frozen normal such a slip opens no gap; the force acts a twentieth of an element aside. In return the matrix
keeps one entry for each node where layers hardly slide, in place of nine (order 1).
"""


@dataclass(frozen=True)
class Interface:
    """The two faces that meet above a layer.

    Attributes:
        layer: the lower layer, 0 at the bottom.
        lower: its upper face, whose nodes carry the contact.
        upper: the lower face of the next layer.
    """

    layer: int
    lower: SharedFace
    upper: SharedFace


class Pairing:
    """Weights between the faces of some interfaces.

    Args:
        spaces: nodal spaces of the mesh.
        stack: the mesh with its facets.
        layers: the lower layers of the interfaces.

    Attributes:
        interfaces: their faces.
        nodes: this rank's local nodes on the lower faces, ghosts included.
        numbers: their global numbers.
        masters: global numbers of the nodes on the upper faces.
        rows: weights of the masters for each of ``nodes``.
        coverage: part of each one's share of its face that lies on the upper face.
    """

    def __init__(self, spaces: NodalSpaces, stack: StackMesh, layers: list[int]) -> None:
        self.comm = spaces.mesh.comm
        self.interfaces = [
            Interface(k, *(SharedFace(spaces, stack.facets(tag)) for tag in (lower_tag(k), upper_tag(k))))
            for k in layers
        ]
        self.nodes = np.concatenate([face.lower.local for face in self.interfaces])
        self.numbers = np.concatenate([face.lower.numbers[face.lower.index_of_local] for face in self.interfaces])
        self.masters = np.concatenate([face.upper.numbers for face in self.interfaces])
        self.rows = csr_matrix((len(self.nodes), len(self.masters)))
        self.coverage: Floats = np.zeros(len(self.nodes))

    def update(self, positions: Floats) -> None:
        """Pair anew where the faces now are.

        Args:
            positions: current positions of this rank's local nodes in m, shape (nodes, 3).
        """
        weights = [self._weights(face, positions) for face in self.interfaces]
        self.rows = csr_matrix(block_diag([weight.rows for weight in weights]))
        self.coverage = np.concatenate([weight.coverage for weight in weights])

    def _weights(self, face: Interface, positions: Floats) -> mortar.Weights:
        lower, upper = (side.gather(positions)[:, :2] for side in (face.lower, face.upper))
        mine = face.lower.elements[self.comm.rank :: self.comm.size]
        parts = self.comm.allgather(mortar.integrals(lower, mine, upper, face.upper.elements, SNAP))
        coupling, covered, whole = (sum(part[1:], start=part[0]) for part in zip(*parts, strict=True))
        weights = _with_nearest(mortar.normalised(coupling, covered, whole), lower, upper)
        here = face.lower.index_of_local
        return mortar.Weights(csr_matrix(weights.rows[here]), weights.coverage[here])

    def facing(self, positions: Floats) -> Floats:
        """Weighted positions of what each of ``nodes`` faces in m, shape (nodes, 3).

        Args:
            positions: of this rank's local nodes in m, shape (nodes, 3).
        """
        masters = np.concatenate([face.upper.gather(positions) for face in self.interfaces])
        facing: Floats = self.rows @ masters
        return facing

    def groups(self) -> Iterator[tuple[Integers, Integers, Floats]]:
        """Positions in ``nodes`` that face equally many masters, those masters' numbers and weights, (n, masters)."""
        counts = np.diff(self.rows.indptr)
        for count in np.unique(counts[counts > 0]):
            members = np.flatnonzero(counts == count)
            entries = self.rows.indptr[members][:, None] + np.arange(count)
            yield members, self.masters[self.rows.indices[entries]], self.rows.data[entries]


def _with_nearest(weights: mortar.Weights, lower: Floats, upper: Floats) -> mortar.Weights:
    """Weights in which nodes that nothing covers follow the nearest node, without a force: slip goes on past an edge.

    Args:
        weights: of the upper nodes for each lower one.
        lower: positions in plan in m, shape (lower nodes, 2).
        upper: positions in plan in m, shape (upper nodes, 2).
    """
    open_ = np.flatnonzero(weights.coverage == 0)
    if not len(open_):
        return weights
    _, nearest = cKDTree(upper).query(lower[open_])
    more = csr_matrix((np.ones(len(open_)), (open_, nearest)), weights.rows.shape)
    return mortar.Weights(csr_matrix(weights.rows + more), weights.coverage)
