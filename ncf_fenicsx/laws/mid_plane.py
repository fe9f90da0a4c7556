"""Bending of a layer apart from its membrane stiffness."""

from __future__ import annotations

from typing import Any

from ncf_fenicsx.kinds import impossible, parameter
from ncf_fenicsx.laws.elasticity import BendingLaw
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.neo_hookean import plane_stress_energy
from ncf_fenicsx.units import PositiveStress


class MidPlane(BendingLaw):
    """A neo-Hookean sheet with a bending modulus; the fibres' own stress is that at the mid-plane.

    A layer's yarns slide past each other as it bends, so its bending stiffness is far below that of a solid sheet of
    the fibres' modulus: per width it is modulus t^3 / (12 (1 - poisson^2)) here, whatever the fibres' law and strain.
    """

    kind = "mid_plane"
    modulus: PositiveStress = parameter("0.1 GPa", description="modulus in bending (not in the paper)")
    poisson: float = parameter(0.2, gt=-1, lt=1, description="Poisson's ratio in bending (not in the paper)")

    def check(self, scene: Any) -> None:
        """Raise where a layer has several elements through it, or is stiffer in bending than in its plane."""
        if set(scene.stack.elements_through) != {1}:
            raise impossible("stack.through", scene.stack.through, "expected 1 with laws.bending, taken at mid-plane")
        stiffness = scene.laws.in_plane.stiffness
        if self.modulus > stiffness:
            raise impossible("laws.bending.modulus", self.modulus, f"expected at most the fibres' {stiffness:g} Pa")

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3."""
        return plane_stress_energy(in_plane_cauchy_green, self.modulus, self.poisson)

    @property
    def stiffness(self) -> Expression:
        """Bending modulus in Pa."""
        return self.modulus
