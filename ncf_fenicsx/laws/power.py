"""Power law of compaction."""

from __future__ import annotations

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.compaction import CompactionLaw
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import PositiveStress


class Power(CompactionLaw):
    """A (Vf^b - Vf0^b): the field's A Vf^b (Robitaille and Gauvin 1998), made stress-free at Vf0 (as Toll 1998 has it).

    The defaults meet the paper's shifted curve at Vf 0.50 and 0.60.
    """

    kind = "power"
    scale: PositiveStress = parameter("6.97455 MPa", description="factor A: the stress that Vf = 1 would give")
    exponent: float = parameter(9.93265, ge=1, description="exponent b; 7 to 15.5 for tows")

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """A (Vf^b - Vf0^b) in Pa."""
        return self.scale * (volume_fraction**self.exponent - initial_volume_fraction**self.exponent)
