"""The deformed fabric as contact sees it: where its points are, how it moved in the step, what presses on its faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh.faces import NodalSpaces
from ncf_fenicsx.parameters.kinds import Constants


@dataclass(frozen=True)
class DeformedBody:
    """Fields and constants that forms of contact are written with.

    Attributes:
        spaces: nodal spaces of the mesh.
        displacement: trial displacement in m.
        start: displacement in m at the start of the step.
        variation: test function.
        constants: makes constants.
        own_pressure: pressure in Pa, per reference area, that the layer's stress has on its faces, evaluated at nodes;
            None unless a contact asks for it.
        natural_stiffness: compaction tangent over thickness in Pa/m, that factors of stiffness refer to.
        thickness: of a layer in m.
    """

    spaces: NodalSpaces
    displacement: Any
    start: Any
    variation: Any
    constants: Constants
    own_pressure: Expression | None
    natural_stiffness: float
    thickness: float

    @property
    def position(self) -> Expression:
        """Current positions in m."""
        return ufl.SpatialCoordinate(self.spaces.mesh) + self.displacement

    @property
    def step_displacement(self) -> Expression:
        """Displacement in m since the start of the step."""
        return self.displacement - self.start
