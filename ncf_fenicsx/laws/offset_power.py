"""Power law of the fibre volume fraction gained."""

from __future__ import annotations

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.compaction import CompactionLaw
from ncf_fenicsx.laws.kinematics import Expression


class OffsetPower(CompactionLaw):
    """(k (Vf - Vf0))^n, as fitted to stacks of carbon and flax (three-parameter law with k, n and Vf0).

    Its slope is zero at Vf0, where a free layer would have no stiffness at all: Vf - Vf0 is rounded off at the corner
    by a hyperbola of width ``toe``. The defaults meet the paper's shifted curve at Vf 0.50 and 0.60.
    """

    kind = "offset_power"
    k: float = parameter(225.8515, gt=0, description="factor k in Pa^(1/n)")
    n: float = parameter(2.791795, ge=1, description="exponent n")
    toe: float = parameter(0.005, gt=0, lt=0.1, description="Vf over which the corner at Vf0 is rounded")

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """(k x)^n - (k toe)^n in Pa, x the rounded Vf - Vf0, equal to toe at Vf0."""
        gain = volume_fraction - initial_volume_fraction
        rounded = (gain + (gain**2 + 4 * self.toe**2) ** 0.5) / 2
        return (self.k * rounded) ** self.n - (self.k * self.toe) ** self.n
