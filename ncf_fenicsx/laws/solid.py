"""[laws.solid]: an isotropic elastic solid in place of the fabric."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import ufl

from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Conditions, Law
from ncf_fenicsx.parameters.kinds import parameter
from ncf_fenicsx.parameters.units import PositiveStress

NEARLY_INCOMPRESSIBLE = 0.4999
"""Largest Poisson's ratio whose forces were found right within 1 %: docs/verification.md."""
LOCKS_ABOVE = 0.45
"""Poisson's ratio from which on full integration is cautioned of: docs/verification.md has what it costs at 0.49."""
POINT_PRESSURE_HOLDS_TO = 0.45
"""Largest Poisson's ratio at which the stress at a single point, J there included, may stand for the pressure."""


class SolidLaw(Law):
    """Isotropic elastic solid in place of the fabric, to compare with general codes."""

    family = "solid"
    modulus: PositiveStress = parameter("1 MPa", description="Young's modulus at small strain")
    poisson: float = parameter(0.2, gt=-1, le=NEARLY_INCOMPRESSIBLE, description="Poisson's ratio at small strain")

    volume_integration: Literal["reduced", "full"] = parameter(
        "reduced",
        description="rule for changes of volume: reduced, or full as in general codes, which locks",
    )

    def caution(self, conditions: Conditions) -> str | None:
        """Full integration locks."""
        del conditions
        if self.volume_integration != "full" or self.poisson <= LOCKS_ABOVE:
            return None
        return (
            f"volume_integration = 'full' locks at poisson = {self.poisson:g}: forces are too high, by several times "
            "near 0.5; 'reduced' does not"
        )

    @abstractmethod
    def shape_energy(self, kinematics: Kinematics) -> Expression:
        """Part of W in J/m3 whose moduli are of the size of mu."""

    @abstractmethod
    def volume_energy(self, volume_ratio: Expression) -> Expression:
        """Part of W in J/m3 that follows J alone and has the modulus that grows without bound as nu -> 1/2."""

    def energy(self, kinematics: Kinematics) -> Expression:
        """W in J/m3."""
        return self.shape_energy(kinematics) + self.volume_energy(kinematics.volume_ratio)

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

    def shape_energy(self, kinematics: Kinematics) -> Expression:
        """mu/2 (I1 - 3) - mu ln J in J/m3."""
        stretch = (ufl.tr(kinematics.right_cauchy_green) - 3) / 2
        return self.shear_modulus * (stretch - ufl.ln(kinematics.volume_ratio))

    def volume_energy(self, volume_ratio: Expression) -> Expression:
        """lambda/2 (ln J)^2 in J/m3."""
        lame = self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return lame / 2 * ufl.ln(volume_ratio) ** 2


class SolidSplit(SolidLaw):
    """W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2, with the constants of Young's modulus and Poisson's ratio."""

    kind = "split"

    def shape_energy(self, kinematics: Kinematics) -> Expression:
        """mu/2 (J^(-2/3) I1 - 3) in J/m3."""
        isochoric = kinematics.volume_ratio ** (-2 / 3) * ufl.tr(kinematics.right_cauchy_green)
        return self.shear_modulus / 2 * (isochoric - 3)

    def volume_energy(self, volume_ratio: Expression) -> Expression:
        """K/2 (J - 1)^2 in J/m3."""
        bulk = self.modulus / (3 * (1 - 2 * self.poisson))
        return bulk / 2 * (volume_ratio - 1) ** 2
