"""What every tool owes the rest of the program."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx import motion
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.motion import Segment
from ncf_fenicsx.parts import Part, parameter
from ncf_fenicsx.units import Clearance, Length, Penalty


class Tool(Part):
    """A rigid tool on a path; its reference point is its tip, the lowest point of its surface."""

    family = "tool"
    position: tuple[Length, Length] = parameter(
        ("0 mm", "0 mm"), description="x and y of the tip at the start, in the stack's axes"
    )
    clearance: Clearance = parameter("0 mm", description="height of the tip over the stack at start")
    path: tuple[Segment, ...] = parameter(
        ({"travel": ("0 mm", "0 mm", "-0.5 mm"), "speed": "1 mm/min"},),
        min_length=1,
        description="travels and holds, one after the other",
    )
    penalty: Penalty = parameter(
        1000.0,
        description="contact stiffness in Pa/m, or a factor on the compaction tangent over the layer's thickness",
    )

    def tip(self, top: float, time: float) -> NDArray[np.float64]:
        """Place of the tip (m) at a time (s), over a stack whose undeformed top is at the height ``top`` (m)."""
        start = np.array([*self.position, top + self.clearance])
        return start + motion.displacement(self.path, time)

    @abstractmethod
    def signed_distance(self, point: Expression) -> Expression:
        """Distance (m) of a point, given relative to the tip, from the tool's surface; negative inside the tool."""

    @abstractmethod
    def section(self) -> NDArray[np.float64]:
        """Outline in the plane across y, relative to the tip, in m, shape (points, 2): for pictures."""
