"""Kozeny-Carman permeability."""

from __future__ import annotations

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.permeability import PermeabilityLaw
from ncf_fenicsx.units import PositiveLength


class KozenyCarman(PermeabilityLaw):
    """r^2 / (4 k) (1 - Vf)^3 / Vf^2, with a constant k along and one across the fibres."""

    kind = "kozeny_carman"
    fibre_radius: PositiveLength = parameter("3.6 um", description="radius r of a fibre")
    constant_along: float = parameter(0.6, gt=0, description="Kozeny constant along the fibres; 0.5 to 0.7")
    constant_across: float = parameter(11.0, gt=0, description="Kozeny constant across them; about 11")

    @property
    def packing_limit(self) -> float:
        """Solid fibre."""
        return 1.0

    def along(self, volume_fraction: Expression) -> Expression:
        """Permeability in m2 along the fibres."""
        return self._permeability(volume_fraction, self.constant_along)

    def across(self, volume_fraction: Expression) -> Expression:
        """Permeability in m2 across the fibres."""
        return self._permeability(volume_fraction, self.constant_across)

    def _permeability(self, vf: Expression, constant: float) -> Expression:
        return self.fibre_radius**2 / (4 * constant) * (1 - vf) ** 3 / vf**2
