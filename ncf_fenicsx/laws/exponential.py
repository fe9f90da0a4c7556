"""The paper's compaction stress (Eq. 3, Table 2), made stress-free in the undeformed state."""

from __future__ import annotations

import math

from ncf_fenicsx.contracts import CompactionLaw
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.parts import parameter
from ncf_fenicsx.units import PositiveStress, Stress


class Exponential(CompactionLaw):
    """sigma_beta(Vf) - sigma_beta(Vf0) with sigma_beta(Vf) = beta1^(beta2 Vf - beta3) + beta4.

    As printed, the paper's constants give tension (-962 Pa) in the undeformed fabric (Vf0 = 0.398), which would make
    it shrink by itself. With the shift the pressure is zero at Vf0 and grows monotonically.
    """

    kind = "exponential"
    beta1: PositiveStress = parameter("96605 Pa", description="base of the exponential")
    beta2: float = parameter(1.5238, gt=0, description="factor of Vf in the exponent")
    beta3: float = parameter(-0.0176, description="offset of the exponent")
    beta4: Stress = parameter("-2254 Pa", description="additive constant, cancelled by the shift")

    def as_printed(self, volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) of Eq. 3 in Pa, without the shift."""
        return self.beta1 ** (self.beta2 * volume_fraction - self.beta3) + self.beta4

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) - sigma_beta(Vf0) in Pa."""
        return self.as_printed(volume_fraction) - self.as_printed(initial_volume_fraction)

    def tangent(self, volume_fraction: float, initial_volume_fraction: float) -> float:
        """-d pressure / d lambda_3 in Pa, with d Vf / d lambda_3 = -Vf^2 / Vf0."""
        slope = math.log(self.beta1) * self.beta2 * (self.as_printed(volume_fraction) - self.beta4)
        return slope * volume_fraction**2 / initial_volume_fraction
