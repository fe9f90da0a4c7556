"""Cells of a stack as they stand on each other: their lower and upper corners, and which cell is next in a layer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.hexahedra import FACES

Integers = NDArray[np.int64]

CORNERS = 8
"""Nodes of a cell at its corners, the first ones whatever its order."""
OPPOSITE = FACES[::-1]
"""The face across from each face, its corners in the same order."""
NONE = -1


@dataclass(frozen=True)
class Upright:
    """This rank's cells, as they stand on each other.

    Attributes:
        lower: local nodes at the corners of each cell's lower face, shape (cells, 4).
        upper: those of its upper face, each over the lower one of the same place.
        below: cell that shares the lower face, `NONE` where a layer that may part or the stack ends, shape (cells,).
        above: cell that shares the upper face, likewise.
    """

    lower: Integers
    upper: Integers
    below: Integers
    above: Integers

    @classmethod
    def of(cls, scalars: Any) -> Upright:
        """Those of a nodal space, whose rank has whole columns of cells."""
        topology = scalars.mesh.topology
        topology.create_connectivity(3, 2)
        count = topology.index_map(3).size_local
        corners = scalars.dofmap.list[:count, :CORNERS].astype(np.int64)
        heights = scalars.tabulate_dof_coordinates()[:, 2][corners]
        down = np.argmin(heights[:, FACES].mean(axis=2), axis=1)
        lower = np.take_along_axis(corners, FACES[down], axis=1)
        upper = np.take_along_axis(corners, OPPOSITE[down], axis=1)
        facets = topology.connectivity(3, 2).array.reshape(-1, len(FACES))[:count]
        cells = np.arange(count)
        floor, roof = facets[cells, down], facets[cells, len(FACES) - 1 - down]
        on_floor = np.full(topology.index_map(2).size_local + topology.index_map(2).num_ghosts, NONE, dtype=np.int64)
        under_roof = on_floor.copy()
        on_floor[floor], under_roof[roof] = cells, cells
        return cls(lower, upper, below=under_roof[floor], above=on_floor[roof])
