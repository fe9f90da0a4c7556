"""How far a field of cell means is off a smooth one in the plane: an estimate of its error from the field alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import la
from numpy.typing import NDArray

from ncf_fenicsx.mesh.upright import Upright

Floats = NDArray[np.float64]

ALONG = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
MASS: Floats = np.kron(ALONG, ALONG).astype(np.float64)
"""Mean products of the four bilinear shape functions of a rectangle, nodes in tensor order."""


class Recovery:
    """Smooths cell means in the plane of the layers by averages at nodes (Zienkiewicz and Zhu 1987).

    Only cells at one height of one layer are averaged: how the field varies through the layers is told by
    `ThroughProfile`.

    Args:
        scalars: nodal space of the mesh.
        volumes: of this rank's cells in m3.
        upright: the cells as they stand on each other.
    """

    def __init__(self, scalars: Any, volumes: Floats, upright: Upright) -> None:
        self._volumes, self._nodes = volumes, upright.upper  # around a node of an upper face, all below are at a height
        self._sums = la.vector(scalars.dofmap.index_map, dtype=np.float64)
        self._around = self._sum_at_nodes(np.ones(len(volumes)))

    def _sum_at_nodes(self, values: Floats) -> Floats:
        """Of the cells below each local node, weighted by volume, on all ranks."""
        sums = self._sums.array
        sums[:] = 0.0
        np.add.at(sums, self._nodes.ravel(), np.repeat(values * self._volumes, self._nodes.shape[1]))
        self._sums.scatter_reverse(la.InsertMode.add)
        self._sums.scatter_forward()
        return sums.copy()

    def off(self, means: Floats) -> Floats:
        """Smoothed less given field at the four corners of each cell in plan, shape (cells, 4)."""
        smooth = self._sum_at_nodes(means)[self._nodes] / self._around[self._nodes]
        difference: Floats = smooth - means[:, None]
        return difference

    def squares(self, means: Floats) -> Floats:
        """Mean square in each cell of smoothed less given field, shape (cells,)."""
        off = self.off(means)
        squares: Floats = np.einsum("ci,ij,cj->c", off, MASS, off)
        return squares
