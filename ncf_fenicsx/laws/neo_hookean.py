"""In-plane neo-Hookean elasticity of the fibres, in the in-plane invariants only."""

from __future__ import annotations

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.elasticity import HyperelasticInPlaneLaw
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import PositiveStress


class NeoHookean(HyperelasticInPlaneLaw):
    """W = mu/2 (tr C_s - 2 - 2 ln J_s) + lambda/2 (ln J_s)^2, so S_s = mu (I - C_s^-1) + lambda ln J_s C_s^-1.

    The paper's Eq. 1 uses the three-dimensional J, so that compaction across the thickness strains the fibres; here
    only the stretch of the fibres' plane does. mu and lambda are those of plane stress: a strip pulled in its
    plane has Young's modulus ``modulus`` and Poisson's ratio ``poisson``.
    """

    kind = "neo_hookean"
    modulus: PositiveStress = parameter("242 GPa", description="Young's modulus of the fibres")
    poisson: float = parameter(0.2, gt=-1, lt=1, description="Poisson's ratio in the plane (not in the paper)")

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3."""
        return plane_stress_energy(in_plane_cauchy_green, self.modulus, self.poisson)

    @property
    def stiffness(self) -> Expression:
        """Young's modulus in Pa."""
        return self.modulus


def plane_stress_energy(C_s: Expression, modulus: Expression, poisson: Expression) -> Expression:
    """Neo-Hookean energy in J/m3 of a sheet with a Young's modulus (Pa) and Poisson's ratio in its plane."""
    mu, lame = modulus / (2 * (1 + poisson)), modulus * poisson / (1 - poisson**2)
    log_area_stretch = ufl.ln(ufl.det(C_s)) / 2
    return mu / 2 * (ufl.tr(C_s) - 2 - 2 * log_area_stretch) + lame / 2 * log_area_stretch**2
