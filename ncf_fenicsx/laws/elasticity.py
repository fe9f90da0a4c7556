"""Elastic laws: of the fibres in their plane, of transverse shear, of isotropic solids."""

from __future__ import annotations

from abc import abstractmethod

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Law, number
from ncf_fenicsx.units import PositiveStress


class InPlaneLaw(Law):
    """Fibre elasticity: second Piola-Kirchhoff stress S_s in the fibres' plane."""

    family = "in_plane"

    @abstractmethod
    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s in Pa, shape (2, 2); its virtual work is S_s : variation(C_s) / 2."""

    @property
    @abstractmethod
    def stiffness(self) -> Expression:
        """Largest in-plane modulus in Pa: it sets the forces that round-off leaves unbalanced."""


class HyperelasticInPlaneLaw(InPlaneLaw):
    """Fibre elasticity with an energy in C_s."""

    @abstractmethod
    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3 of reference volume."""

    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s = 2 dW/dC_s in Pa, shape (2, 2)."""
        C_s = ufl.variable(kinematics.in_plane_cauchy_green)
        return 2 * ufl.diff(self.energy(C_s), C_s)


class BendingLaw(HyperelasticInPlaneLaw):
    """Bending of a layer apart from its membrane: the fibres act at its mid-plane, and this energy on what varies.

    Its work over the volume is counted less that at the mid-plane, so that a uniform strain meets the fibres alone.
    """

    family = "bending"


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
