"""Compressible neo-Hookean solid with a logarithmic volume term."""

from __future__ import annotations

import ufl

from ncf_fenicsx.laws.elasticity import SolidLaw
from ncf_fenicsx.laws.kinematics import Expression, Kinematics


class SolidLogarithmic(SolidLaw):
    """W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "logarithmic"

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        mu, log_ratio = self.shear_modulus, ufl.ln(kinematics.volume_ratio)
        lame = self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return mu / 2 * (ufl.tr(kinematics.right_cauchy_green) - 3) - mu * log_ratio + lame / 2 * log_ratio**2
