"""What every law, tool and interface of a kind owes the rest of the program.

A law pairs a strain with a stress; its virtual work is stress : variation(strain). Parameters are fields of the part,
and named constants in the compiled forms.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx import motion
from ncf_fenicsx.kinematics import Expression, Kinematics
from ncf_fenicsx.motion import Segment
from ncf_fenicsx.parts import Part, parameter
from ncf_fenicsx.units import Clearance, Length, Penalty


class InPlaneLaw(Part):
    """Fibre elasticity: second Piola-Kirchhoff stress S_s from C_s."""

    family = "in_plane"

    @abstractmethod
    def stress(self, in_plane_cauchy_green: Expression) -> Expression:
        """S_s = 2 dW/dC_s in Pa, shape (2, 2)."""

    @property
    @abstractmethod
    def stiffness(self) -> float:
        """Largest in-plane modulus in Pa: it sets the forces that round-off leaves unbalanced."""


class CompactionLaw(Part):
    """Compaction pressure of the fabric across its thickness."""

    family = "compaction"

    @abstractmethod
    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Pressure in Pa, positive in compaction, at the speed the law was fitted at."""

    @abstractmethod
    def tangent(self, volume_fraction: float, initial_volume_fraction: float) -> float:
        """-d pressure / d lambda_3 in Pa."""


class RateLaw(Part):
    """Factor on the compaction pressure that depends on speed."""

    family = "rate"

    @abstractmethod
    def factor(self, speed: Expression) -> Expression:
        """Dimensionless factor, 1 at the speed the compaction law was fitted at."""


class ShearLaw(Part):
    """Transverse shear stress between the fibres' plane and the thickness."""

    family = "shear"

    @abstractmethod
    def stress(self, kinematics: Kinematics) -> Expression:
        """Stress conjugate to (C_13, C_23), in Pa, shape (2,)."""


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
