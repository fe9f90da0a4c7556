"""Compressible neo-Hookean solid with a logarithmic volume term."""

from __future__ import annotations

import ufl

from ncf_fenicsx.contracts import SolidLaw
from ncf_fenicsx.kinematics import Expression, Kinematics
from ncf_fenicsx.parts import parameter
from ncf_fenicsx.units import PositiveStress


class SolidLogarithmic(SolidLaw):
    """W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "logarithmic"
    modulus: PositiveStress = parameter("1 MPa", description="Young's modulus at small strain")
    poisson: float = parameter(0.2, gt=-1, lt=0.5, description="Poisson's ratio at small strain")

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        mu, log_ratio = self.shear_modulus, ufl.ln(kinematics.volume_ratio)
        lame = self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return mu / 2 * (ufl.tr(kinematics.right_cauchy_green) - 3) - mu * log_ratio + lame / 2 * log_ratio**2

    @property
    def shear_modulus(self) -> Expression:
        """Mu in Pa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def stiffness(self) -> float:
        """Lambda + 2 mu in Pa."""
        return float(self.modulus * (1 - self.poisson) / ((1 + self.poisson) * (1 - 2 * self.poisson)))
