"""Sphere: a ball indenter."""

from __future__ import annotations

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import parameter
from ncf_fenicsx.parameters.units import PositiveLength
from ncf_fenicsx.tools.rigid_surface import Interval, Tool, circle, rounded_block


class Sphere(Tool):
    """Rigid sphere."""

    kind = "sphere"
    radius: PositiveLength = parameter("5 mm", description="radius of the sphere")

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the sphere."""
        height = point[2] - self.radius
        return ufl.sqrt(point[0] ** 2 + point[1] ** 2 + height**2) - self.radius

    def section(self) -> NDArray[np.float64]:
        """Circle, in m, shape (points, 2)."""
        return circle(self.radius)

    def surface(self, window: tuple[Interval, Interval]) -> NDArray[np.float64]:
        """The whole sphere, in m, as a grid of points of shape (rows, points in a row, 3)."""
        del window
        return rounded_block((0.0, 0.0), self.radius, 180.0)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the sphere along x and along y in m."""
        return self.radius, self.radius

    @property
    def reach(self) -> tuple[Interval, Interval]:
        """Least and largest x and y in m, relative to the tip."""
        return (-self.radius, self.radius), (-self.radius, self.radius)

    @property
    def axle(self) -> float | None:
        """Height of the centre over the tip in m."""
        return self.radius
