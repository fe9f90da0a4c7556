"""The estimated error of the field of Vf by the mesh: in the plane of the layers, and through them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.state_fields import StateField
from ncf_fenicsx.mesh.upright import Upright
from ncf_fenicsx.output.error_estimate import Recovery
from ncf_fenicsx.output.face_pressures import FacePressures
from ncf_fenicsx.output.through_profile import ThroughProfile

Floats = NDArray[np.float64]


class VfError:
    """Root mean squares of what the means of the cells cannot show, over the field's change from rest.

    With bending apart from the membrane, one element through each layer is the model: only the plane counts.

    Args:
        problem: what is measured.
        volumes: of this rank's cells in m3.

    Attributes:
        recovery: smooths the field in the plane.
        volumes: as given.
        state: what the estimate remembers.
    """

    def __init__(self, problem: Problem, volumes: Floats) -> None:
        self._comm, self.volumes = problem.comm, volumes
        self._rest = problem.scene.stack.initial_volume_fraction
        scalars = problem.contacts.body.spaces.scalars
        upright = Upright.of(scalars)
        self.recovery = Recovery(scalars, volumes, upright)
        self._through: ThroughProfile | None = None
        self.state: list[StateField] = []
        if problem.scene.laws.bending is None:
            self._through, self._faces = ThroughProfile(problem, upright), FacePressures(problem, upright)
            self.state = self._through.state

    def observe(self, vf: Floats, stress: Floats, pressures: Floats | None) -> dict[str, float]:
        """Columns of the history.

        Args:
            vf: means of this rank's cells.
            stress: of the stress across the layer in Pa.
            pressures: of contacts at local nodes in Pa, as contacts tell them; None without any.
        """
        plane, through = self.recovery.squares(vf), np.zeros_like(vf)
        if self._through is not None:
            through = self._through.squares(vf, stress, self._faces.at_nodes(pressures))
        parts = np.stack([plane, through, (vf - self._rest) ** 2]) @ self.volumes
        in_plane, across, change = self._comm.allreduce(parts)
        if change <= 0:
            return {"vf_error": 0.0, "vf_error_in_plane": 0.0}
        return {
            "vf_error": float(np.sqrt((in_plane + across) / change)),
            "vf_error_in_plane": float(np.sqrt(in_plane / change)),
        }
