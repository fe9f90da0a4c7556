"""Compressible neo-Hookean solid, split into change of shape and change of volume."""

from __future__ import annotations

import ufl

from ncf_fenicsx.laws.elasticity import SolidLaw
from ncf_fenicsx.laws.kinematics import Expression, Kinematics


class SolidSplit(SolidLaw):
    """W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "split"

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        J, bulk = kinematics.volume_ratio, self.modulus / (3 * (1 - 2 * self.poisson))
        shape = J ** (-2 / 3) * ufl.tr(kinematics.right_cauchy_green) - 3
        return self.shear_modulus / 2 * shape + bulk / 2 * (J - 1) ** 2
