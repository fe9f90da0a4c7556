"""Laws of permeability."""

from __future__ import annotations

from abc import abstractmethod

from ncf_fenicsx.contracts.law import Law
from ncf_fenicsx.kinematics import Expression


class PermeabilityLaw(Law):
    """Permeability of the fibres from their volume fraction."""

    family = "permeability"

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
