"""[laws.solid]: an isotropic elastic solid in place of the fabric."""

from __future__ import annotations

from abc import abstractmethod

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Law
from ncf_fenicsx.units import PositiveStress


class SolidLaw(Law):
    """Isotropic elastic solid in place of the fabric, to compare with general codes."""

    family = "solid"
    modulus: PositiveStress = parameter("1 MPa", description="Young's modulus at small strain")
    poisson: float = parameter(0.2, gt=-1, lt=0.5, description="Poisson's ratio at small strain")

    @abstractmethod
    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""

    @property
    def shear_modulus(self) -> Expression:
        """Mu in Pa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def stiffness(self) -> float:
        """Stiffness lambda + 2 mu in Pa of a layer pressed across its thickness, its sides held."""
        return float(self.modulus * (1 - self.poisson) / ((1 + self.poisson) * (1 - 2 * self.poisson)))


class SolidLogarithmic(SolidLaw):
    """W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "logarithmic"

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        mu, log_ratio = self.shear_modulus, ufl.ln(kinematics.volume_ratio)
        lame = self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return mu / 2 * (ufl.tr(kinematics.right_cauchy_green) - 3) - mu * log_ratio + lame / 2 * log_ratio**2


class SolidSplit(SolidLaw):
    """W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "split"

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        J, bulk = kinematics.volume_ratio, self.modulus / (3 * (1 - 2 * self.poisson))
        shape = J ** (-2 / 3) * ufl.tr(kinematics.right_cauchy_green) - 3
        return self.shear_modulus / 2 * shape + bulk / 2 * (J - 1) ** 2
