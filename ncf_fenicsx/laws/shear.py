"""[laws.shear]: transverse shear between the plane of the fibres and the thickness."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated

import ufl
from pydantic import Field

from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Law, number
from ncf_fenicsx.laws.monotone_cubic import MonotoneCubic, Tabulated
from ncf_fenicsx.parameters.kinds import parameter
from ncf_fenicsx.parameters.units import PositiveStress

LEAST_SLIDE = 1e-10
"""Slide that the size of a slide is rounded off with: the size itself has no derivative where there is none."""
Angle = Annotated[float, Field(gt=0, lt=90)]


class ShearLaw(Law):
    """Transverse shear between the fibres' plane and the thickness."""

    family = "shear"

    @abstractmethod
    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""

    @property
    def small_strain_modulus(self) -> float:
        """G_t in Pa of the undeformed fabric: 2 W / slide^2."""
        slide = 1e-6
        F = ufl.as_matrix([[1.0, 0.0, slide], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        return 2 * number(self.energy(Kinematics(F, ufl.as_ufl(1.0)))) / slide**2


class ConstantShear(ShearLaw):
    """W = G_t / 2 (C_13^2 + C_23^2). The paper has no such stress, and without it the layer is singular."""

    kind = "constant"
    fitted = ("modulus",)
    modulus: PositiveStress = parameter("0.1 MPa", description="transverse shear modulus G_t")

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        return self.modulus / 2 * ufl.dot(kinematics.transverse_shear, kinematics.transverse_shear)


class GrowingShear(ConstantShear):
    """W = G_t / 2 (Vf / Vf0)^q (C_13^2 + C_23^2).

    An energy, so that the tangent stays symmetric: sheared fabric then presses on its faces by dW/d lambda_3 as well.
    """

    kind = "growing"
    exponent: float = parameter(5.0, ge=0, description="exponent q of Vf / Vf0 (not in the paper)")

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        growth = (kinematics.volume_fraction / kinematics.initial_volume_fraction) ** self.exponent
        return growth * super().energy(kinematics)


class ShearTable(Tabulated, ShearLaw):
    """W = integral of tau(slide) from 0 to sqrt(C_13^2 + C_23^2), tau a measured table: shear that softens.

    tau is the stress per reference area in simple shear, and the slide the tangent of its angle. The curve is
    monotone and continuously differentiable, straight beyond its end, and its slope at rest is that to the first entry.
    """

    kind = "table"
    columns = ("angle", "stress")
    angle: tuple[Angle, ...] = parameter(
        (0.023, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0),
        min_length=1,
        description="angles of simple shear in degrees, ascending from above 0",
    )
    stress: tuple[PositiveStress, ...] = parameter(
        (
            "3.7 kPa",
            "10.3 kPa",
            "16.9 kPa",
            "23.4 kPa",
            "31.9 kPa",
            "42.6 kPa",
            "50.1 kPa",
            "59.0 kPa",
            "61.9 kPa",
        ),
        min_length=1,
        description="shear stress at each, ascending (Broberg et al. 2024: a preform of 18 plies with binder)",
    )

    @property
    def _curve(self) -> MonotoneCubic:
        return MonotoneCubic.from_origin(tuple(math.tan(math.radians(angle)) for angle in self.angle), self.stress)

    def shear_stress(self, slide: Expression) -> Expression:
        """Stress tau in Pa over the tangent of the angle."""
        return self._curve(slide)

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        shear = kinematics.transverse_shear
        slide = (ufl.dot(shear, shear) + LEAST_SLIDE**2) ** 0.5
        return self._curve.integral(slide)
