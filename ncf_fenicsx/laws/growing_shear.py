"""Transverse shear with a modulus that grows as the fabric is compacted."""

from __future__ import annotations

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.constant_shear import ConstantShear
from ncf_fenicsx.laws.kinematics import Expression, Kinematics


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
