"""How far a field of cell means is off a smooth one: an estimate of its error from the field alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import la
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ALONG = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
MASS: Floats = np.kron(np.kron(ALONG, ALONG), ALONG)
"""Mean products of the eight trilinear shape functions of a box, nodes in tensor order."""


class Recovery:
    """Smooths cell means by averages at nodes (Zienkiewicz and Zhu 1987).

    Nodes of two layers that stand in one place count as one: the pressure between the layers is one, and with one
    element through each layer nothing else shows how the field varies across them.

    Args:
        scalars: P1 space of the mesh.
        volumes: of this rank's cells in m3.
    """

    def __init__(self, scalars: Any, volumes: Floats) -> None:
        self.comm, self._volumes = scalars.mesh.comm, volumes
        self._corners = scalars.dofmap.list[: len(volumes)]
        self._sums = la.vector(scalars.dofmap.index_map, dtype=np.float64)
        # whole columns of cells stand on one rank, so that it has all nodes of each place that it has one of
        _, places = np.unique(scalars.tabulate_dof_coordinates().round(9), axis=0, return_inverse=True)
        self._place = places.ravel()
        self._around = self._sum_at_nodes(np.ones(len(volumes)))

    def _sum_at_nodes(self, values: Floats) -> Floats:
        """Of the cells around each local node, weighted by volume, on all ranks."""
        sums = self._sums.array
        sums[:] = 0.0
        np.add.at(sums, self._corners.ravel(), np.repeat(values * self._volumes, 8))
        self._sums.scatter_reverse(la.InsertMode.add)
        self._sums.scatter_forward()
        return np.asarray(np.bincount(self._place, sums)[self._place])

    def error(self, means: Floats, rest: float) -> float:
        """Root mean square of smoothed less given field over that of the field's change from rest; 0 without change."""
        smooth = (self._sum_at_nodes(means) / self._around)[self._corners]
        off = smooth - means[:, None]
        squares = np.array(
            [np.einsum("ci,ij,cj,c->", off, MASS, off, self._volumes), self._volumes @ (means - rest) ** 2]
        )
        error, change = self.comm.allreduce(squares)
        return float(np.sqrt(error / change)) if change > 0 else 0.0
