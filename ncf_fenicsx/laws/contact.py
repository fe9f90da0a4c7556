"""Contact of a face: gap to pressure to virtual work, by each way of enforcing it. Knows no tool, layer or law.

All pressures are per reference area. Contact acts at nodes: no over-constraint, no pressure checkerboard.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal

import ufl
from pydantic import PositiveInt

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import Kind, Settings, parameter
from ncf_fenicsx.parameters.units import Penalty

TOUCHING = 1e-15
"""Gap in m below which a node touches: faces that start on each other do, whatever the round-off of their positions."""
STIFFEST_RIGID, STIFFEST_LAYERS = 16_000.0, 160.0
"""Factors on a layer's own stiffness above which penalties of rigid surfaces, and between layers, are not raised: what
they let through is then below 0.1 % of the force, and Newton's method fails where stiffer faces part."""


def most_raised(stiffest: float, penalty: float, natural: float) -> float:
    """Largest factor that a penalty may be raised by, at least 1.

    Args:
        stiffest: one of the factors above.
        penalty: in Pa/m.
        natural: a layer's own stiffness in Pa/m.
    """
    return max(stiffest * natural / penalty, 1.0)


@dataclass(frozen=True)
class Touch:
    """What is known of two faces where they may touch.

    Attributes:
        gap: distance in m, negative in penetration.
        stiffness: penalty in Pa/m.
        multiplier: contact pressure of the last update in Pa; None unless the enforcement keeps one.
        own_pressure: pressure in Pa that the layer's own stress has on its face; None unless the enforcement asks.
        kept: 1 where contact is kept whatever the gap, else 0; None where it never is.
        rests: whether weight presses the faces together; a tool that just touches does not hold the fabric up.
    """

    gap: Expression
    stiffness: Expression
    multiplier: Expression = None
    own_pressure: Expression = None
    kept: Expression = None
    rests: bool = True

    def pushed(self, pressure: Expression) -> Expression:
        """A pressure (Pa) where it pushes or contact is kept, else 0; faces that rest on each other are in contact."""
        closed = ufl.ge(pressure, -self.stiffness * TOUCHING) if self.rests else ufl.gt(pressure, 0)
        if self.kept is not None:
            closed = ufl.Or(closed, ufl.gt(self.kept, 0.5))
        return ufl.conditional(closed, pressure, 0)


class Enforcement(Kind):
    """How it is enforced that faces do not penetrate each other."""

    family = "contact"
    keeps_multiplier: ClassVar[bool] = False
    uses_own_pressure: ClassVar[bool] = False

    @property
    def symmetric(self) -> bool:
        """Whether its tangent is symmetric."""
        return True

    @abstractmethod
    def pressure(self, touch: Touch) -> Expression:
        """Contact pressure in Pa, at least 0 unless contact is kept."""

    def work(self, touch: Touch, gap_change: Expression, own_pressure_change: Expression) -> Expression:
        """Virtual work (J/m2) for changes of the gap (m) and of the layer's own pressure (Pa)."""
        del own_pressure_change
        return -self.pressure(touch) * gap_change


class PenaltyContact(Enforcement):
    """Pressure grows with penetration: p = k max(-g, 0)."""

    kind = "penalty"

    def pressure(self, touch: Touch) -> Expression:
        """K max(-g, 0) in Pa."""
        return touch.pushed(-touch.stiffness * touch.gap)


class NitscheContact(Enforcement):
    """The contact pressure is the layer's own, corrected by the gap: p = max(p_n - k g, 0), p_n = -n . sigma n J_s.

    Virtual work -p dg + theta/k (p - p_n) dp_n (Chouly, Hild, Renard 2015); theta = 1 has an energy.
    """

    kind = "nitsche"
    uses_own_pressure = True
    variant: Literal["incomplete", "skew", "symmetric"] = parameter(
        "incomplete", description="weight theta of the change of stress: 0, -1 or 1"
    )

    @property
    def symmetric(self) -> bool:
        """Only with theta = 1."""
        return self.variant == "symmetric"

    @property
    def theta(self) -> int:
        """Weight of the change of stress."""
        return {"incomplete": 0, "skew": -1, "symmetric": 1}[self.variant]

    def pressure(self, touch: Touch) -> Expression:
        """max(p_n - k g, 0) in Pa."""
        return touch.pushed(touch.own_pressure - touch.stiffness * touch.gap)

    def work(self, touch: Touch, gap_change: Expression, own_pressure_change: Expression) -> Expression:
        """-p dg + theta/k (p - p_n) dp_n in J/m2."""
        work = super().work(touch, gap_change, own_pressure_change)
        if not self.theta:
            return work
        excess = self.pressure(touch) - touch.own_pressure
        return work + self.theta / touch.stiffness * excess * own_pressure_change


class AugmentedLagrangian(Enforcement):
    """A multiplier takes over from the penalty, update by update: p = max(lambda - k g, 0), then lambda = p.

    One update for each accepted step; more only while penetration is above the tolerance.
    """

    kind = "augmented_lagrangian"
    keeps_multiplier = True
    tolerance: float = parameter(1e-4, gt=0, description="largest penetration over the layer's thickness")
    max_updates: PositiveInt = parameter(20, description="updates within a step at which it is cut")

    def pressure(self, touch: Touch) -> Expression:
        """max(lambda - k g, 0) in Pa."""
        return touch.pushed(touch.multiplier - touch.stiffness * touch.gap)


class Friction(Settings):
    """Coulomb friction, regularised: an elastic stick of finite stiffness, whose traction slides at mu p."""

    coefficient: float = parameter(..., gt=0, description="coefficient of friction mu")
    stiffness: Penalty = parameter(
        1.0, description="stick stiffness in Pa/m, or a factor on the compaction tangent over the layer's thickness"
    )


def friction_traction(stuck: Expression, pressure: Expression, coefficient: Expression) -> Expression:
    """Tangential traction in Pa: that of a stick, no more than mu p (return mapping of Coulomb's law).

    Args:
        stuck: traction if nothing slid in Pa, shape (3,).
        pressure: contact pressure in Pa.
        coefficient: mu.
    """
    limit, size = coefficient * ufl.max_value(pressure, 0), ufl.sqrt(ufl.dot(stuck, stuck))
    return ufl.conditional(ufl.gt(size, limit), limit / size, 1) * stuck


def tangential(vector: Expression, normal: Expression) -> Expression:
    """Kind of a vector in the plane across a unit normal."""
    return vector - ufl.dot(vector, normal) * normal
