"""Laws of permeability."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from ncf_fenicsx.kinds import impossible
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import Law


class PermeabilityLaw(Law):
    """Permeability of the fibres from their volume fraction."""

    family = "permeability"

    def check(self, scene: Any) -> None:
        """Raise for a solid, which has no fibres, and where the fabric starts at or beyond the packing limit."""
        if scene.laws.solid is not None:
            raise impossible("output.permeability.kind", self.kind, "expected none for a solid, without fibres")
        initial = scene.stack.initial_volume_fraction
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
