"""Sizes that a solution is measured against: lengths, the forces that carry the stack, and what round-off leaves.

Residuals are forces in N, so a solve has converged when they are small against the load; on fine meshes under small
loads round-off in the stiffest stress may be larger than that, and is the floor.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.contacts import Contacts
from ncf_fenicsx.mechanics.form_constants import FormConstants
from ncf_fenicsx.mechanics.material import Volumes
from ncf_fenicsx.mechanics.supports import Supports
from ncf_fenicsx.mesh import StackMesh, compat
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]

CELLS_AT_NODE = 4
"""Cells of a layer that add up their round-off at a node."""
UPRIGHT = 0.1
"""Share of a cell's upright face whose round-off in stress is felt at a node, where that is more than its face in the
plane: so where elements are ten times shorter than high. 0.04 was measured on strips of 120 to 960 elements."""


class Scales:
    """Sizes of a problem.

    Args:
        scene: the case.
        stack: its mesh.
        contacts: of its fabric.
        supports: what holds it.
        constants: makes constants.
        volumes: measures of the reference volume.

    Attributes:
        length: that increments are measured against in m.
        sliding: whether a tool travels along the surface in the present step.
    """

    def __init__(
        self,
        scene: Scene,
        stack: StackMesh,
        contacts: Contacts,
        supports: Supports,
        constants: FormConstants,
        volumes: Volumes,
    ) -> None:
        self.length, self.sliding = scene.stack.thickness, False
        self._settings, self._stiffness = scene.solver, scene.laws.stiffness
        self._stack, self._contacts, self._supports = stack, contacts, supports
        self._comm = stack.mesh.comm
        self._volume_form = constants(1.0) * volumes.all

    @cached_property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off leaves: in the stiffest stress, or in penalty times coordinate."""
        cells = self._comm.allreduce(len(self._stack.layer))
        volume = self._comm.allreduce(float(fem.assemble_scalar(compat.compile_form(self._volume_form))))
        face = volume / cells / self.length
        pulled_at = max(face, UPRIGHT * np.sqrt(self._comm.allreduce(self._upright_squares()) / cells))
        round_off = self._stiffness * pulled_at + self._contacts.stiffness * self._stack.extent * face
        return float(CELLS_AT_NODE * np.finfo(float).eps * round_off * np.sqrt(cells))

    def _upright_squares(self) -> float:
        """Sum of the squares of the larger upright face in m2 of this rank's cells."""
        geometry = self._stack.mesh.geometry
        extents = np.ptp(geometry.x[geometry.dofmap], axis=1)
        return float(((extents[:, :2].max(axis=1) * extents[:, 2]) ** 2).sum())

    @property
    def increment_cap(self) -> float:
        """Largest nodal increment in m that Newton's method may take in the present step.

        A contact that passes from node to node has a jump for each; large corrections leap over many of them.
        """
        cap, sliding = self._settings.increment_cap, self._settings.sliding_increment_cap
        return self.length * (min(cap, sliding) if self.sliding else cap)

    def load(self, residual: Floats) -> float:
        """Sum of the vertical forces in N that carry the fabric, which imbalance is measured against.

        Args:
            residual: out-of-balance forces in N of the owned dofs, reactions included.
        """
        carried = float(np.abs(residual[self._supports.vertical_dofs]).sum())
        if self._contacts.mould is not None:
            carried += float(np.abs(self._contacts.mould.nodal_forces()[:, 2]).sum())
        return float(self._comm.allreduce(carried))
