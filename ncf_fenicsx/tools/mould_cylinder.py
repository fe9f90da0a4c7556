"""Cylindrical mould with its axis along y."""

from __future__ import annotations

import ufl

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.tools._round_mould import RoundMould


class CylinderMould(RoundMould):
    """Rigid ridge or trough along y."""

    kind = "cylinder"

    def from_centre(self, point: Expression, height: Expression) -> Expression:
        """Distance (m) of a point from the axis, over which it has a height (m)."""
        return ufl.sqrt(point[0] ** 2 + height**2)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the surface in m, along x."""
        return self.radius, None
