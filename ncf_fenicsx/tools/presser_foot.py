"""Presser foot: a flat rectangle with rounded edges."""

from __future__ import annotations

from typing import Self

import numpy as np
import ufl
from numpy.typing import NDArray
from pydantic import model_validator

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveLength
from ncf_fenicsx.tools.rigid_surface import Interval, Tool, arc, rounded_block


class PresserFoot(Tool):
    """Rigid rectangular foot, its bottom edges and vertical corners rounded with one radius.

    All points within ``edge`` of a smaller prism with sharp edges, which stands ``edge`` over the tip. What has
    penetrated into that prism is pushed down, never sideways, although a wall may be nearer.
    """

    kind = "presser_foot"
    size: tuple[PositiveLength, PositiveLength] = parameter(("20 mm", "20 mm"), description="lengths along x and y")
    edge: PositiveLength = parameter("2 mm", description="radius of the rounding of its edges")

    @model_validator(mode="after")
    def _has_a_flat_core(self) -> Self:
        if min(self.size) <= 2 * self.edge:
            raise impossible("size", list(self.size), f"expected more than 2 edge = {2 * self.edge:g} m")
        return self

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the foot; smooth outside and as deep as the edge inside."""
        beside_x, beside_y = (abs(point[axis]) - self.size[axis] / 2 + self.edge for axis in (0, 1))
        below = self.edge - point[2]
        square = sum(ufl.max_value(length, 0) ** 2 for length in (beside_x, beside_y, below))
        under_core = ufl.And(ufl.le(beside_x, 0), ufl.le(beside_y, 0))
        return ufl.conditional(under_core, -point[2], ufl.sqrt(square) - self.edge)

    def section(self) -> NDArray[np.float64]:
        """Flat bottom, rounded edges and some of the walls, in m, shape (points, 2)."""
        half, top = self.size[0] / 2, self.edge + self.size[0] / 4
        right = arc(self.edge, 0, 90, 31) + np.array([half - self.edge, self.edge])
        right = np.vstack([right, [half, top]])
        return np.vstack([(right * np.array([-1.0, 1.0]))[::-1], right])

    def surface(self, window: tuple[Interval, Interval]) -> NDArray[np.float64]:
        """Bottom, rounded edges and some of the walls, in m, as a grid of points of shape (rows, points, 3)."""
        del window
        block = rounded_block((self.size[0] / 2 - self.edge, self.size[1] / 2 - self.edge), self.edge, 90.0)
        return np.concatenate([block, block[-1:] + np.array([0.0, 0.0, self.size[0] / 4])])

    @property
    def reach(self) -> tuple[Interval, Interval]:
        """Least and largest x and y in m, relative to the tip."""
        length, width = self.size
        return (-length / 2, length / 2), (-width / 2, width / 2)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the rounding along x and along y in m."""
        return self.edge, self.edge
