"""Cylinder lying along y, of finite or infinite width: the roller."""

from __future__ import annotations

from typing import Self

import numpy as np
import ufl
from numpy.typing import NDArray
from pydantic import model_validator

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import NonNegativeLength, PositiveLength, WidthOrInfinite
from ncf_fenicsx.tools.rigid_surface import ENDLESS, Interval, Tool, circle


class Cylinder(Tool):
    """Rigid cylinder with axis y and ends, sharp or rounded, at ``width / 2`` on both sides of its position.

    Its rolling surface and the rounding push, not its flat ends: fabric that has penetrated between the roundings is
    pushed out radially, never sideways through the end, although the end may be nearer.
    """

    kind = "cylinder"
    radius: PositiveLength = parameter("2.5 mm", description="radius of the rolling surface")
    width: WidthOrInfinite = parameter("30 mm", description='length along y, or "infinite"')
    edge: NonNegativeLength = parameter("0 mm", description="radius of the rounding of its ends; zero is sharp")

    @model_validator(mode="after")
    def _edge_fits(self) -> Self:
        if self.edge > self.radius:
            raise impossible("edge", self.edge, f"expected at most radius = {self.radius:g} m")
        if self.width is not None and self.edge > self.width / 2:
            raise impossible("edge", self.edge, f"expected at most width / 2 = {self.width / 2:g} m")
        return self

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the rolling surface; beside it, from the rounding or the end.

        Smooth outside and, with an edge, as deep as the edge inside.
        """
        height = point[2] - self.radius
        radial = ufl.sqrt(point[0] ** 2 + height**2) - self.radius
        if self.width is None:
            return radial
        past_rolling = abs(point[1]) - self.width / 2 + self.edge
        beside = ufl.sqrt(ufl.max_value(radial + self.edge, 0) ** 2 + past_rolling**2) - self.edge
        return ufl.conditional(ufl.le(past_rolling, 0), radial, beside)

    def section(self) -> NDArray[np.float64]:
        """Circle, in m, shape (points, 2)."""
        return circle(self.radius)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the cylinder, and that of its rounded ends, in m."""
        return self.radius, None if self.width is None else self.edge or None

    @property
    def reach(self) -> tuple[Interval, Interval]:
        """Least and largest x and y in m, relative to the tip."""
        return (-self.radius, self.radius), ENDLESS if self.width is None else (-self.width / 2, self.width / 2)

    @property
    def axle(self) -> float | None:
        """Height of the axis over the tip in m."""
        return self.radius
