"""Transverse shear with a constant modulus."""

from __future__ import annotations

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.elasticity import ShearLaw
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.units import PositiveStress


class ConstantShear(ShearLaw):
    """W = G_t / 2 (C_13^2 + C_23^2). The paper has no such stress, and without it the layer is singular."""

    kind = "constant"
    modulus: PositiveStress = parameter("0.1 MPa", description="transverse shear modulus G_t")

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        return self.modulus / 2 * ufl.dot(kinematics.transverse_shear, kinematics.transverse_shear)
