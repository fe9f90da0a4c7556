"""Gebart's permeability of aligned fibres."""

from __future__ import annotations

import math
from typing import Literal

from ncf_fenicsx.kinds import parameter
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.permeability import PermeabilityLaw
from ncf_fenicsx.units import PositiveLength

PACKINGS = {
    "quadratic": (57.0, 16 / (9 * math.pi * math.sqrt(2)), math.pi / 4),
    "hexagonal": (53.0, 16 / (9 * math.pi * math.sqrt(6)), math.pi / (2 * math.sqrt(3))),
}
"""Constants c, C1 and Vf_max of each packing (Gebart 1992, J. Compos. Mater. 26, 1100)."""


class Gebart(PermeabilityLaw):
    """Along: 8 r^2 / c (1 - Vf)^3 / Vf^2; across: C1 r^2 (sqrt(Vf_max / Vf) - 1)^(5/2), for regular packings.

    Of the fibres in a tow: gaps between tows and stitches make a fabric more permeable than this.
    """

    kind = "gebart"
    fibre_radius: PositiveLength = parameter("3.6 um", description="radius r of a fibre")
    packing: Literal["quadratic", "hexagonal"] = parameter("hexagonal", description="arrangement of the fibres")

    @property
    def packing_limit(self) -> float:
        """Vf_max, where the fibres touch."""
        return PACKINGS[self.packing][2]

    def along(self, volume_fraction: Expression) -> Expression:
        """Permeability in m2 along the fibres."""
        shape = PACKINGS[self.packing][0]
        return 8 * self.fibre_radius**2 / shape * (1 - volume_fraction) ** 3 / volume_fraction**2

    def across(self, volume_fraction: Expression) -> Expression:
        """Permeability in m2 across the fibres."""
        _, factor, limit = PACKINGS[self.packing]
        return factor * self.fibre_radius**2 * ((limit / volume_fraction) ** 0.5 - 1) ** 2.5
