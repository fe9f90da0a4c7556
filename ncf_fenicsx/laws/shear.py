"""[laws.shear]: transverse shear between the plane of the fibres and the thickness."""

from __future__ import annotations

from abc import abstractmethod

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Law, number
from ncf_fenicsx.units import PositiveStress


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
