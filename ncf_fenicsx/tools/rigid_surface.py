"""What every rigid surface owes the rest of the program: tools that press from above, moulds that lie below."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.laws.contact import Enforcement, Friction
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import Choice, Kind, parameter
from ncf_fenicsx.parameters.units import Clearance, Length, Penalty
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.path import Segment

Interval = tuple[float, float]
ENDLESS: Interval = (-math.inf, math.inf)


class RigidSurface(Kind):
    """A rigid surface; its reference point is its tip, a point of the surface."""

    position: tuple[Length, Length] = parameter(
        ("0 mm", "0 mm"),
        description="x and y of the tip at the start, in the stack's axes; with a mesh file, unless given, at its "
        "planes of symmetry, or over its middle where there is none",
    )
    clearance: Clearance = parameter("0 mm", description="distance along z between the tip and the stack at the start")
    penalty: Penalty = parameter(
        1000.0,
        description="contact stiffness in Pa/m, or a factor on the compaction tangent over the layer's thickness",
    )
    contact: Annotated[Enforcement, Choice("contact", "penalty")] = parameter({}, description="how it is enforced")
    friction: Friction | None = parameter(None, description="Coulomb friction with the fabric; none unless given")

    @abstractmethod
    def signed_distance(self, point: Expression) -> Expression:
        """Distance (m) of a point, given relative to the tip, from the surface; negative inside the rigid body."""

    @abstractmethod
    def section(self) -> NDArray[np.float64]:
        """Outline in the plane across y, relative to the tip, in m, shape (points, 2): for pictures."""

    def surface(self, window: tuple[Interval, Interval]) -> NDArray[np.float64]:
        """Surface relative to the tip, in m, as a grid of points of shape (rows, points in a row, 3): for pictures.

        The outline as long along y as the surface reaches, with its ends closed.

        Args:
            window: least and largest x and y (m), relative to the tip, at which a surface without an end is cut off.
        """
        (least_x, largest_x), (least_y, largest_y) = self.reach
        (x, right), (y, back) = window
        whole = math.isfinite(largest_x - least_x)
        outline = self.section() if whole else clipped(self.section(), x, right)
        ends = (least_y, largest_y) if math.isfinite(largest_y - least_y) else (y, back)
        rows = [np.insert(outline, 1, end, axis=1) for end in ends]
        if math.isfinite(largest_y - least_y):
            middle = np.broadcast_to(outline.mean(axis=0), outline.shape)
            first, last = (np.insert(middle, 1, end, axis=1) for end in ends)
            rows = [first, *rows, last]
        return np.stack(rows)

    @property
    def radii(self) -> tuple[float | None, float | None]:
        """Smallest radius (m) that elements have to follow along x and along y; None where there is none."""
        return None, None

    @property
    def reach(self) -> tuple[Interval, Interval]:
        """Least and largest x and y (m) of the surface, relative to its tip; infinite where it has no end."""
        return ENDLESS, ENDLESS

    @property
    def under_force(self) -> bool:
        """Whether a force decides its height somewhere on its path."""
        return False


class Tool(RigidSurface):
    """A rigid tool on a path, pressing from above; its tip is the lowest point of its surface."""

    family = "tool"
    path: tuple[Segment, ...] = parameter(
        ({"travel": ("0 mm", "0 mm", "-0.5 mm"), "speed": "1 mm/min"},),
        min_length=1,
        description="travels, holds and forces, one after the other",
    )

    def tip(self, top: float, time: float) -> NDArray[np.float64]:
        """Place of the tip (m) at a time (s), over a stack whose undeformed top is at the height ``top`` (m).

        What a segment under force control adds to its height is not known before a run.
        """
        start = np.array([*self.position, top + self.clearance])
        return start + motion.displacement(self.path, time)

    @property
    def under_force(self) -> bool:
        """Whether a force decides its height somewhere on its path."""
        return any(segment.force is not None for segment in self.path)

    @property
    def axle(self) -> float | None:
        """Height (m) over the tip of the axis that the tool turns about when it rolls; None if it cannot."""
        return None


class Mould(RigidSurface):
    """A rigid mould that lies still below the stack, in place of the plane that otherwise carries it."""

    family = "mould"

    def tip(self, bottom: float) -> NDArray[np.float64]:
        """Place of the tip (m) below a stack whose undeformed bottom is at the height ``bottom`` (m)."""
        return np.array([*self.position, bottom - self.clearance])


def arc(radius: float, start: float, end: float, points: int = 181) -> NDArray[np.float64]:
    """Arc about the origin in the plane across y, in m, shape (points, 2).

    Args:
        radius: its radius in m.
        start: angle in degrees from straight down, towards x.
        end: the same of its other end.
        points: number of points.
    """
    angle = np.radians(np.linspace(start, end, points))
    return radius * np.stack([np.sin(angle), -np.cos(angle)], axis=1)


def circle(radius: float) -> NDArray[np.float64]:
    """Circle that stands on the tip, in m, shape (181, 2)."""
    return arc(radius, -180, 180) + np.array([0.0, radius])


def clipped(outline: NDArray[np.float64], least: float, largest: float) -> NDArray[np.float64]:
    """Part of an outline with ascending x between two x in m, shape (points, 2)."""
    inside = outline[(outline[:, 0] > least) & (outline[:, 0] < largest)]
    first, last = max(least, outline[0, 0]), min(largest, outline[-1, 0])
    ends = [[[x, np.interp(x, outline[:, 0], outline[:, 1])]] for x in (first, last)]
    return np.concatenate([ends[0], inside, ends[1]])


def rounded_block(half: tuple[float, float], radius: float, upwards: float, points: int = 24) -> NDArray[np.float64]:
    """Lower part of all points within a radius of a flat rectangle, as a grid of shape (rows, points in a row, 3).

    The lowest point of its middle is the origin; with a rectangle of no size it is a sphere.

    Args:
        half: half the rectangle's lengths along x and y in m.
        radius: in m.
        upwards: angle in degrees from straight down at which it ends.
        points: number of points of a quarter of a row.
    """
    quarter = np.linspace(0.0, np.pi / 2, points)
    around = np.concatenate([quarter + turn * np.pi / 2 for turn in range(4)] + [[0.0]])
    signs = np.repeat([[1, 1], [-1, 1], [-1, -1], [1, -1]], points, axis=0)
    corners = np.concatenate([signs, signs[:1]]) * np.array(half)
    up = np.radians(np.linspace(0.0, upwards, points))[:, None]
    x = corners[:, 0] + radius * np.sin(up) * np.cos(around)
    y = corners[:, 1] + radius * np.sin(up) * np.sin(around)
    z = np.broadcast_to(radius * (1.0 - np.cos(up)), x.shape)
    rows = np.stack([x, y, z], axis=2)
    return np.concatenate([np.zeros_like(rows[:1]), rows])
