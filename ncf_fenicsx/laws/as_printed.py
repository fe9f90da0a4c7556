"""The paper's in-plane elasticity as printed (Eq. 1), kept to be compared with."""

from __future__ import annotations

from typing import Any

import ufl

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.elasticity import InPlaneLaw
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.units import PositiveStress


class NeoHookeanAsPrinted(InPlaneLaw):
    """sigma = mu/J (B - I) + lambda (J - 1) I with the three-dimensional J, of which the fibres' plane is kept.

    With P = I - n n, the stress P sigma P has the components mu (I + g g^T - C_s^-1) + lambda J (J - 1) C_s^-1 in the
    convected base of the plane, times 1/J; g = C_s^-1 (C_13, C_23). It is no derivative of an energy: compaction
    changes the stress in the plane, and a stretch of the plane does not change that across it.
    """

    kind = "as_printed"
    symmetric = False
    modulus: PositiveStress = parameter("242 GPa", description="Young's modulus of the fibres")
    poisson: float = parameter(0.3, gt=0, lt=0.5, description="Poisson's ratio (not in the paper)")

    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s in Pa, shape (2, 2)."""
        inverse, J = ufl.inv(kinematics.in_plane_cauchy_green), kinematics.volume_ratio
        slope = ufl.dot(inverse, kinematics.transverse_shear)
        strain = ufl.Identity(2) + ufl.outer(slope, slope) - inverse
        return self.shear_modulus * strain + self.lame * J * (J - 1) * inverse

    @property
    def shear_modulus(self) -> Expression:
        """Mu in Pa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def lame(self) -> Expression:
        """Lambda in Pa."""
        return self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))

    @property
    def stiffness(self) -> Expression:
        """Lambda + 2 mu in Pa."""
        return self.lame + 2 * self.shear_modulus

    def caution(self, scene: Any) -> str | None:
        """Not symmetric, and unstable almost at once: where lambda times the compaction passes G_t, layers crimp."""
        modulus = scene.laws.shear.small_strain_modulus
        return (
            f"the stress as printed has no energy, so the tangent is not symmetric (LU); compaction presses the fibres "
            f"in their plane by lambda = {self.lame / 1e9:.1f} GPa times its strain, and layers lose stability once "
            f"that passes G_t = {modulus / 1e6:.3g} MPa: from a compaction of {100 * modulus / self.lame:.2g} % on"
        )
