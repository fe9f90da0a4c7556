"""What contacts press with on both faces of each layer, node by node."""

from __future__ import annotations

import numpy as np
from dolfinx import la
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.upright import NONE, Upright

Floats = NDArray[np.float64]


class FacePressures:
    """Pressures at nodes; a layer's lower face has them from the forces of the one below.

    Args:
        problem: whose contacts press.
        upright: its cells as they stand on each other.
    """

    def __init__(self, problem: Problem, upright: Upright) -> None:
        self._layers, self._spaces = problem.contacts.layers, problem.contacts.body.spaces
        self._order = np.argsort(self._spaces.numbers)
        self._area = self._lower_areas(upright)

    def _lower_areas(self, upright: Upright) -> Floats:
        """Share of each local node in the undeformed lower faces of layers that may part in m2, of all ranks."""
        nodes = upright.lower[upright.below == NONE]
        corners = self._spaces.scalars.tabulate_dof_coordinates()[nodes]
        areas = np.linalg.norm(np.cross(corners[:, 3] - corners[:, 0], corners[:, 2] - corners[:, 1]), axis=1) / 2
        shares = la.vector(self._spaces.scalars.dofmap.index_map, dtype=np.float64)
        np.add.at(shares.array, nodes.ravel(), np.repeat(areas / 4, 4))
        shares.scatter_reverse(la.InsertMode.add)
        shares.scatter_forward()
        return shares.array.copy()

    def at_nodes(self, pressures: Floats | None) -> Floats:
        """Pressures in Pa at this rank's local nodes on both faces, of this moment; collective.

        Args:
            pressures: of tools, mould, and on the upper faces of layers, 0 elsewhere; None where nothing touches.
        """
        forces = np.zeros(len(self._area))
        for contact in self._layers:
            parts = self._spaces.mesh.comm.allgather(contact.residual())
            numbers, values = (np.concatenate(part) for part in zip(*parts, strict=True))
            place = np.searchsorted(self._spaces.numbers, numbers, sorter=self._order)
            local = self._order[np.minimum(place, len(self._order) - 1)]
            here = self._spaces.numbers[local] == numbers
            np.add.at(forces, local[here], -values[here, 2])  # a residual: what pushes upwards is negative
        above = np.divide(forces, self._area, out=np.zeros_like(forces), where=self._area > 0)
        return above if pressures is None else pressures + above
