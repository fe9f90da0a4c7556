"""What cylindrical and spherical moulds have in common."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.tools.outlines import arc
from ncf_fenicsx.tools.rigid_surface import Mould
from ncf_fenicsx.units import PositiveLength


class RoundMould(Mould):
    """Rigid mould of constant curvature: a hill with its crest at the tip, or a hollow with its lowest point there."""

    radius: PositiveLength = parameter("100 mm", description="radius of the surface")
    shape: Literal["convex", "concave"] = parameter("convex", description="a hill, or a hollow less deep than radius")

    @abstractmethod
    def from_centre(self, point: Expression, height: Expression) -> Expression:
        """Distance (m) of a point from the axis or centre, over which it has a height (m)."""

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the surface, positive above it."""
        if self.shape == "convex":
            return self.from_centre(point, point[2] + self.radius) - self.radius
        return self.radius - self.from_centre(point, point[2] - self.radius)

    def section(self) -> NDArray[np.float64]:
        """Arc of 120 degrees, in m, shape (points, 2)."""
        hollow = arc(self.radius, -60, 60) + np.array([0.0, self.radius])
        return hollow * np.array([1.0, -1.0]) if self.shape == "convex" else hollow
