"""Gutowski's compaction law, with a limit that fibres cannot be packed beyond."""

from __future__ import annotations

from typing import Any

from ncf_fenicsx.kinds import impossible, parameter
from ncf_fenicsx.laws.compaction import CompactionLaw, positive
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import PositiveStress


class Gutowski(CompactionLaw):
    """As (sqrt(Vf / Vf0) - 1) / (sqrt(Va / Vf) - 1)^4 (Gutowski 1987): without bound as Vf nears Va.

    Below Vf0, where the formula has an extremum, the curve goes on straight. The default of As meets the paper's
    shifted curve at Vf 0.60.
    """

    kind = "gutowski"
    spring: PositiveStress = parameter("107.906 Pa", description="spring constant As")
    limit: float = parameter(0.80, gt=0, le=1, description="largest possible Vf, Va")

    def check(self, scene: Any) -> None:
        """Raise if the fabric starts beyond the limit."""
        initial = scene.stack.initial_volume_fraction
        if self.limit <= initial:
            raise impossible("laws.compaction.limit", self.limit, f"expected above Vf0 = {initial:.4g}")

    @property
    def packing_limit(self) -> float:
        """Va."""
        return self.limit

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Pressure in Pa, straight below Vf0."""
        gain = volume_fraction - initial_volume_fraction
        vf = initial_volume_fraction + positive(gain)
        bent = ((vf / initial_volume_fraction) ** 0.5 - 1) / ((self.limit / vf) ** 0.5 - 1) ** 4
        slope = 1 / (2 * initial_volume_fraction) / ((self.limit / initial_volume_fraction) ** 0.5 - 1) ** 4
        return self.spring * (bent - slope * positive(-gain))
