"""[output.permeability]: permeability of the fibres along and across them, over their volume fraction."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Literal

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import Conditions, Law
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveLength

PACKINGS = {
    "quadratic": (57.0, 16 / (9 * math.pi * math.sqrt(2)), math.pi / 4),
    "hexagonal": (53.0, 16 / (9 * math.pi * math.sqrt(6)), math.pi / (2 * math.sqrt(3))),
}
"""Constants c, C1 and Vf_max of each packing (Gebart 1992, J. Compos. Mater. 26, 1100)."""


class PermeabilityLaw(Law):
    """Permeability of the fibres from their volume fraction."""

    family = "permeability"

    def check(self, conditions: Conditions) -> None:
        """Raise for a solid, which has no fibres, and where the fabric starts at or beyond the packing limit."""
        if not conditions.has_fibres:
            raise impossible("output.permeability.kind", self.kind, "expected none for a solid, without fibres")
        initial = conditions.initial_volume_fraction
        if initial >= self.packing_limit:
            limit = f"expected a packing limit above Vf0 = {initial:.4g}; it is {self.packing_limit:.4g}"
            raise impossible("output.permeability.kind", self.kind, limit)

    @property
    @abstractmethod
    def packing_limit(self) -> float:
        """Vf at which the fibres leave no way through."""

    @abstractmethod
    def along(self, volume_fraction: Expression) -> Expression:
        """Permeability along the fibres in m2."""

    @abstractmethod
    def across(self, volume_fraction: Expression) -> Expression:
        """Permeability across the fibres in m2."""


class Gebart(PermeabilityLaw):
    """Along: 8 r^2 / c (1 - Vf)^3 / Vf^2; across: C1 r^2 (sqrt(Vf_max / Vf) - 1)^(5/2), for regular packings.

    Of the fibres in a tow: gaps between tows and stitches make a fabric more permeable than this.
    """

    kind = "gebart"
    fitted = ("fibre_radius",)
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


class KozenyCarman(PermeabilityLaw):
    """r^2 / (4 k) (1 - Vf)^3 / Vf^2, with a constant k along and one across the fibres."""

    kind = "kozeny_carman"
    fitted = ("constant_along", "constant_across")
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
