"""The paper's compaction stress (Eq. 3, Table 2)."""

from __future__ import annotations

from typing import Literal

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.compaction import CompactionLaw
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import PositiveStress, Stress


class Exponential(CompactionLaw):
    """sigma_beta(Vf) = beta1^(beta2 Vf - beta3) + beta4, with a choice of what its tensile toe becomes.

    As printed, the paper's constants give tension (-962 Pa) in the undeformed fabric (Vf0 = 0.398) and up to
    Vf = 0.4299: it would shrink by itself. ``shift`` takes the stress at Vf0 off, so that the undeformed fabric is
    free of stress; ``clip`` keeps the printed curve where it presses and lays its toe smoothly to zero; ``raw`` is
    the curve as printed.
    """

    kind = "exponential"
    beta1: PositiveStress = parameter("96605 Pa", description="base of the exponential")
    beta2: float = parameter(1.5238, gt=0, description="factor of Vf in the exponent")
    beta3: float = parameter(-0.0176, description="offset of the exponent")
    beta4: Stress = parameter("-2254 Pa", description="additive constant, cancelled by the shift")
    toe: Literal["shift", "clip", "raw"] = parameter(
        "shift", description="tensile toe of the printed curve: shifted to zero at Vf0, clipped, or raw"
    )
    smoothing: PositiveStress = parameter("100 Pa", description="stress over which clip rounds the corner")

    def as_printed(self, volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) of Eq. 3 in Pa."""
        return self.beta1 ** (self.beta2 * volume_fraction - self.beta3) + self.beta4

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) in Pa; shifted or clipped, it is zero at Vf0."""
        curve = {"shift": self.as_printed, "clip": self._clipped, "raw": self.as_printed}[self.toe]
        at_rest = 0.0 if self.toe == "raw" else curve(initial_volume_fraction)
        return curve(volume_fraction) - at_rest

    def _clipped(self, volume_fraction: Expression) -> Expression:
        """max(sigma_beta, 0) with its corner a hyperbola: smooth, and never without a slope."""
        stress = self.as_printed(volume_fraction)
        return (stress + (stress**2 + 4 * self.smoothing**2) ** 0.5) / 2
