"""Rigid moulds below the stack: cylinders and spheres, convex or concave, and a plane."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Literal

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import parameter
from ncf_fenicsx.parameters.units import PositiveLength
from ncf_fenicsx.tools.rigid_surface import Interval, Mould, arc, rounded_block


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


class SphereMould(RoundMould):
    """Rigid dome or bowl."""

    kind = "sphere"

    def from_centre(self, point: Expression, height: Expression) -> Expression:
        """Distance (m) of a point from the centre, over which it has a height (m)."""
        return ufl.sqrt(point[0] ** 2 + point[1] ** 2 + height**2)

    def surface(self, window: tuple[Interval, Interval]) -> NDArray[np.float64]:
        """Cap of 60 degrees around the tip, in m, as a grid of points of shape (rows, points in a row, 3).

        It ends at the farthest corner of the window, where that is nearer.
        """
        farthest = math.hypot(*(max(map(abs, ends)) for ends in window))
        angle = math.degrees(math.asin(min(farthest / self.radius, math.sin(math.radians(60.0)))))
        hollow = rounded_block((0.0, 0.0), self.radius, angle)
        return hollow * np.array([1.0, 1.0, -1.0]) if self.shape == "convex" else hollow

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the surface along x and along y in m."""
        return self.radius, self.radius


class PlateMould(Mould):
    """Rigid horizontal plane without edges, from which the stack may lift off."""

    kind = "plate"

    def signed_distance(self, point: Expression) -> Expression:
        """Height of the point over the plane in m."""
        return point[2]

    def section(self) -> NDArray[np.float64]:
        """Straight line under any stack, in m, shape (points, 2)."""
        return np.array([[-10.0, 0.0], [10.0, 0.0]])
