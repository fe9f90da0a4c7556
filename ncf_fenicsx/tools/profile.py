"""Profile: a polyline extruded along y."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Self

import numpy as np
import ufl
from numpy.typing import NDArray
from pydantic import model_validator

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import Constants, impossible, parameter
from ncf_fenicsx.parameters.units import Length, PositiveLength
from ncf_fenicsx.tools.rigid_surface import ENDLESS, Interval, Tool, arc

Vector = tuple[float, float]


class Profile(Tool):
    """Rigid body above a polyline, with vertical walls up from both its ends, endless along y.

    Its surface is where the distance from that body is ``rounding``, so that corners which point at the fabric are
    rounded and those which point away from it stay sharp. Heights count from the lowest point of the surface, wherever
    along x it is, and x from the tool's position.
    """

    kind = "profile"
    points: tuple[tuple[Length, Length], ...] = parameter(
        (["-10 mm", "2 mm"], ["-5 mm", "0 mm"], ["5 mm", "0 mm"], ["10 mm", "2 mm"]),
        min_length=2,
        description="corners (x, z) of the polyline, ascending in x",
    )
    rounding: PositiveLength = parameter("0.5 mm", description="radius of the rounding of corners, added all around")

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        x = [point[0] for point in self.points]
        if any(right <= left for left, right in pairwise(x)):
            raise impossible("points", x, "expected ascending x")
        return self

    def with_constants(self, constants: Constants) -> Self:
        """Copy with constants for its numbers, except for the points: these are compiled into the forms."""
        return super().with_constants(constants).model_copy(update={"points": self.points})

    @property
    def _corners(self) -> list[Vector]:
        """The points, the lowest at height zero."""
        lowest = min(z for _, z in self.points)
        return [(x, z - lowest) for x, z in self.points]

    def signed_distance(self, point: Expression) -> Expression:
        """Signed distance in m from the rounded polyline and its walls.

        Smooth as deep as the rounding, except on the line that halves a corner which points away from the fabric.
        """
        x, z = point[0], point[2] - self.rounding
        corners = self._corners
        side = _side(x, z, corners)
        (square, distance), *others = [_from_edge(x, z, side, *edge) for edge in _edges(corners)]
        for other_square, other in others:
            distance = ufl.conditional(ufl.lt(other_square, square), other, distance)
            square = ufl.min_value(other_square, square)
        return distance - self.rounding

    def section(self) -> NDArray[np.float64]:
        """Rounded polyline and some of the walls, in m, shape (points, 2).

        The surface is the lowest of the arcs about the corners and of the segments, all drawn at the same x.
        """
        corners = np.array(self._corners)
        x = np.unique(corners[:, :1] + arc(self.rounding, -90, 90, 61)[:, 0])
        pieces = [_arc_below(x, x0, z0, self.rounding) for x0, z0 in corners]
        pieces += [_segment_below(x, *ends, self.rounding) for ends in pairwise(corners)]
        bottom = np.stack([x, np.min(pieces, axis=0) + self.rounding], axis=1)
        top = bottom[:, 1].max() + np.ptp(x) / 4
        return np.vstack([[x[0], top], bottom, [x[-1], top]])

    @property
    def reach(self) -> tuple[Interval, Interval]:
        """Least and largest x and y in m, relative to the tip."""
        return (self.points[0][0] - self.rounding, self.points[-1][0] + self.rounding), ENDLESS

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Radius of the rounded corners in m, along x."""
        return self.rounding, None


def _edges(corners: list[Vector]) -> Iterator[tuple[Vector, Vector, Vector, float | None]]:
    """Start, direction, outward normal and length of the left wall, the segments and the right wall."""
    yield corners[0], (0.0, 1.0), (-1.0, 0.0), None
    for start, end in pairwise(corners):
        length = math.dist(start, end)
        along = (end[0] - start[0]) / length, (end[1] - start[1]) / length
        yield start, along, (along[1], -along[0]), length
    yield corners[-1], (0.0, 1.0), (1.0, 0.0), None


def _side(x: Expression, z: Expression, corners: list[Vector]) -> Expression:
    """-1 above the polyline, prolonged flat past its ends, and 1 below it."""
    height: Expression = corners[0][1]
    for (x0, z0), (x1, z1) in pairwise(corners):
        covered = ufl.max_value(x - x0, 0) - ufl.max_value(x - x1, 0)
        height = height + (z1 - z0) / (x1 - x0) * covered
    return ufl.conditional(ufl.ge(z, height), -1.0, 1.0)


def _from_edge(
    x: Expression, z: Expression, side: Expression, start: Vector, along: Vector, normal: Vector, length: float | None
) -> tuple[Expression, Expression]:
    """Square of the distance of a point from an edge, and the distance with its sign.

    Beside the edge that is a plain product, with the sign of the normal: a root would have no derivative on the edge.
    Only the distance from an end is a root, with the sign of the side; past the ends of the polyline that is 1, for
    what is beside a wall is beside an edge.
    """
    x, z = x - start[0], z - start[1]
    reach = x * along[0] + z * along[1]
    across = x * normal[0] + z * normal[1]
    beyond = ufl.min_value(reach, 0)
    if length is not None:
        beyond = beyond + ufl.max_value(reach - length, 0)
    square = across**2 + beyond**2
    return square, ufl.conditional(ufl.eq(beyond, 0), across, side * ufl.sqrt(square))


def _arc_below(x: NDArray[np.float64], x0: float, z0: float, radius: float) -> NDArray[np.float64]:
    """Heights of the lower half of a circle at x, in m, shape as x; infinite where it does not reach."""
    # the outermost x may miss the circle by a rounding error
    square = np.where(np.abs(x - x0) <= radius * (1 + 1e-9), np.maximum(radius**2 - (x - x0) ** 2, 0), np.nan)
    return np.nan_to_num(z0 - np.sqrt(square), nan=np.inf)


def _segment_below(
    x: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64], distance: float
) -> NDArray[np.float64]:
    """Heights of a segment moved out by a distance, at x, in m, shape as x; infinite where it does not reach."""
    along = (end - start) / np.linalg.norm(end - start)
    x0, x1 = start[0] + distance * along[1], end[0] + distance * along[1]
    height = start[1] - distance * along[0] + along[1] / along[0] * (x - x0)
    return np.where((x >= x0) & (x <= x1), height, np.inf)
