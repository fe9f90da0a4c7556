"""How far a field of cell means is off a smooth one: an estimate of its error from the field alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import la
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CORNERS = 8
"""Nodes of a cell at its corners, the first ones whatever its order."""
ALONG = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
MASS: Floats = np.kron(np.kron(ALONG, ALONG), ALONG)
"""Mean products of the eight trilinear shape functions of a box, nodes in tensor order."""


class Recovery:
    """Smooths cell means by averages at nodes (Zienkiewicz and Zhu 1987).

    Nodes of two layers at one position count as one: the pressure between the layers is one, and with one
    element through each layer nothing else shows how the field varies across them. At the stack's bottom and top, where
    there is nothing to average with, and where tools leave their peaks, a parabola with the means of the three cells
    next to the face gives the value there.

    Args:
        scalars: nodal space of the mesh.
        volumes: of this rank's cells in m3.
    """

    def __init__(self, scalars: Any, volumes: Floats) -> None:
        self.comm, self._volumes = scalars.mesh.comm, volumes
        self._corners = scalars.dofmap.list[: len(volumes), :CORNERS]
        self._sums = la.vector(scalars.dofmap.index_map, dtype=np.float64)
        # whole columns of cells stand on one rank, so that it has all nodes of each position that it has one of
        coordinates = scalars.tabulate_dof_coordinates().round(9)
        positions, self._place = np.unique(coordinates, axis=0, return_inverse=True)
        self._place = self._place.ravel()
        self._outer = _outermost(positions)
        self._around = self._sum_at_nodes(np.ones(len(volumes)))

    def _sum_at_nodes(self, values: Floats) -> Floats:
        """Of the cells around each local node, weighted by volume, on all ranks."""
        sums = self._sums.array
        sums[:] = 0.0
        np.add.at(sums, self._corners.ravel(), np.repeat(values * self._volumes, CORNERS))
        self._sums.scatter_reverse(la.InsertMode.add)
        self._sums.scatter_forward()
        return np.bincount(self._place, sums).astype(np.float64)

    def _smooth(self, means: Floats) -> Floats:
        """Smoothed values at the corners of cells, shape (cells, 8)."""
        values = self._sum_at_nodes(means) / np.maximum(self._around, np.finfo(float).tiny)  # some are no corners
        face, one, two = self._outer
        values[face] = (20 * values[face] - 18 * values[one] + 4 * values[two]) / 6
        smooth: Floats = values[self._place][self._corners]
        return smooth

    def error(self, means: Floats, rest: float) -> float:
        """Root mean square of smoothed less given field over that of the field's change from rest; 0 without change."""
        off = self._smooth(means) - means[:, None]
        squares = np.array(
            [np.einsum("ci,ij,cj,c->", off, MASS, off, self._volumes), self._volumes @ (means - rest) ** 2]
        )
        error, change = self.comm.allreduce(squares)
        return float(np.sqrt(error / change)) if change > 0 else 0.0


def _outermost(positions: Floats) -> NDArray[np.int64]:
    """Positions on bottom and top, next to each the one within, and the one after it; shape (3, positions).

    Only those whose two neighbours are one and two cells of one height away.

    Args:
        positions: in m, ordered by x, then y, then z; shape (positions, 3).
    """
    first = np.arange(max(len(positions) - 2, 0))
    threes = np.column_stack([first, first + 1, first + 2])
    x, y, z = np.moveaxis(positions[threes], 2, 0)
    column = (np.ptp(x, axis=1) == 0) & (np.ptp(y, axis=1) == 0) & (np.abs(np.diff(z, 2, axis=1)[:, 0]) < 1e-8)
    bottom, top = (positions[:, 2].min(), positions[:, 2].max()) if len(positions) else (0.0, 0.0)
    below, above = threes[column & (z[:, 0] == bottom)], threes[column & (z[:, 2] == top)]
    return np.concatenate([below, above[:, ::-1]]).T
