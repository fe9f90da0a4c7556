"""Cylinder lying along y, of finite or infinite width: the roller."""

from __future__ import annotations

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.contracts import Tool
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.parts import parameter
from ncf_fenicsx.units import PositiveLength, WidthOrInfinite


class Cylinder(Tool):
    """Rigid cylinder with axis y and sharp ends at ``width / 2`` on both sides of its position.

    Its rolling surface alone pushes: fabric that has penetrated near an end is pushed out radially, never sideways
    through the end, although the end may be nearer.
    """

    kind = "cylinder"
    radius: PositiveLength = parameter("2.5 mm", description="radius of the rolling surface")
    width: WidthOrInfinite = parameter("30 mm", description='length along y, or "infinite"')

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the rolling surface; beside it, distance from the cylinder."""
        height = point[2] - self.radius
        radial = ufl.sqrt(point[0] ** 2 + height**2) - self.radius
        if self.width is None:
            return radial
        axial = abs(point[1]) - self.width / 2
        beside = ufl.sqrt(ufl.max_value(radial, 0) ** 2 + axial**2)
        return ufl.conditional(ufl.le(axial, 0), radial, beside)

    def section(self) -> NDArray[np.float64]:
        """Circle, in m, shape (points, 2)."""
        angle = np.linspace(-np.pi, np.pi, 181)
        return self.radius * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
