"""Spherical mould."""

from __future__ import annotations

import ufl

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.tools._round_mould import RoundMould


class SphereMould(RoundMould):
    """Rigid dome or bowl."""

    kind = "sphere"

    def from_centre(self, point: Expression, height: Expression) -> Expression:
        """Distance (m) of a point from the centre, over which it has a height (m)."""
        return ufl.sqrt(point[0] ** 2 + point[1] ** 2 + height**2)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the surface along x and along y in m."""
        return self.radius, self.radius
