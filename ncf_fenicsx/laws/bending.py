"""[laws.bending]: bending of a layer apart from its membrane stiffness."""

from __future__ import annotations

from ncf_fenicsx.kinds import impossible, parameter
from ncf_fenicsx.laws.in_plane import HyperelasticInPlaneLaw, plane_stress_energy
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import Conditions
from ncf_fenicsx.units import PositiveStress


class BendingLaw(HyperelasticInPlaneLaw):
    """Bending of a layer apart from its membrane: the fibres act at its mid-plane, and this energy on what varies.

    Its work over the volume is counted less that at the mid-plane, so that a uniform strain meets the fibres alone.
    """

    family = "bending"


class MidPlane(BendingLaw):
    """A neo-Hookean sheet with a bending modulus; the fibres' own stress is that at the mid-plane.

    A layer's yarns slide past each other as it bends, so its bending stiffness is far below that of a solid sheet of
    the fibres' modulus: per width it is modulus t^3 / (12 (1 - poisson^2)) here, whatever the fibres' law and strain.
    """

    kind = "mid_plane"
    modulus: PositiveStress = parameter("0.1 GPa", description="modulus in bending (not in the paper)")
    poisson: float = parameter(0.2, gt=-1, lt=1, description="Poisson's ratio in bending (not in the paper)")

    def check(self, conditions: Conditions) -> None:
        """Raise where a layer has several elements through it, or is stiffer in bending than in its plane."""
        most = max(conditions.elements_through)
        if most > 1:
            raise impossible("stack.through", most, "expected 1 with laws.bending, taken at mid-plane")
        stiffest = conditions.fibre_modulus
        if self.modulus > stiffest:
            raise impossible("laws.bending.modulus", self.modulus, f"expected at most the fibres' {stiffest:g} Pa")

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3."""
        return plane_stress_energy(in_plane_cauchy_green, self.modulus, self.poisson)

    @property
    def stiffness(self) -> Expression:
        """Bending modulus in Pa."""
        return self.modulus
