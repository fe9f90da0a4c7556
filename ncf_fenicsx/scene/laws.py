"""The constitutive laws of a scene, each chosen by its kind."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from ncf_fenicsx.laws.bending import BendingLaw
from ncf_fenicsx.laws.compaction import CompactionLaw
from ncf_fenicsx.laws.in_plane import InPlaneLaw
from ncf_fenicsx.laws.law import Law, StatefulLaw
from ncf_fenicsx.laws.rate import RateLaw
from ncf_fenicsx.laws.relaxation import RelaxationLaw
from ncf_fenicsx.laws.shear import ShearLaw
from ncf_fenicsx.laws.solid import SolidLaw
from ncf_fenicsx.laws.unloading import UnloadingLaw
from ncf_fenicsx.parameters.kinds import Choice, Constants, Settings, impossible, parameter

PENALTY_VOLUME_FRACTION = 0.60
"""Penalty factors refer to the compaction tangent at this Vf, where the paper's compaction data ends."""


class Laws(Settings):
    """The constitutive laws, each chosen by ``kind``: those of the fabric, or that of a solid in its place."""

    in_plane: Annotated[InPlaneLaw, Choice("in_plane", "neo_hookean")] = parameter({}, description="fibre elasticity")
    bending: Annotated[BendingLaw, Choice("bending", "mid_plane")] | None = parameter(
        None, description="bending apart from the membrane; as that of a solid sheet unless given"
    )
    compaction: Annotated[CompactionLaw, Choice("compaction", "exponential")] = parameter(
        {}, description="pressure over fibre volume fraction"
    )
    rate: Annotated[RateLaw, Choice("rate", "kelly")] = parameter({}, description="dependence on speed")
    relaxation: Annotated[RelaxationLaw, Choice("relaxation", "maxwell")] | None = parameter(
        None, description="pressure that decays in time; none unless given"
    )
    unloading: Annotated[UnloadingLaw, Choice("unloading", "permanent_set")] | None = parameter(
        None, description="opening after compaction; along the curve of loading unless given"
    )
    shear: Annotated[ShearLaw, Choice("shear", "constant")] = parameter({}, description="transverse shear")
    volume_fraction: Literal["thickness", "volume"] = parameter(
        "thickness", description="Vf = Vf0 / lambda_3, as in the paper, or Vf0 / J"
    )
    solid: Annotated[SolidLaw, Choice("solid", "logarithmic")] | None = parameter(
        None, description="isotropic solid in place of the fabric and all its laws; none unless given"
    )

    @model_validator(mode="after")
    def _fabric_or_solid(self) -> Self:
        others = sorted(self.model_fields_set - {"solid"})
        if self.solid is not None and any(getattr(self, name) is not None for name in others):
            raise impossible(
                "solid", self.solid.kind, f"expected no laws of the fabric beside it ({', '.join(others)})"
            )
        return self

    @property
    def chosen(self) -> list[Law]:
        """The laws at work."""
        if self.solid is not None:
            return [self.solid]
        return [law for _, law in self if isinstance(law, Law)]

    @property
    def stateful(self) -> list[StatefulLaw]:
        """Those among them that keep states."""
        return [law for law in self.chosen if isinstance(law, StatefulLaw)]

    def initial_states(self, initial_volume_fraction: float) -> dict[str, float]:
        """Names of all states with their values at the start: Vf, which fabric always keeps, and those of its laws."""
        states = {} if self.solid is not None else {"volume_fraction": initial_volume_fraction}
        for law in self.stateful:
            states |= law.initial_states(initial_volume_fraction)
        return states

    def with_constants(self, constants: Constants) -> Self:
        """Copy whose laws have constants for their numbers."""
        laws = {name: law.with_constants(constants) for name, law in self if isinstance(law, Law)}
        return self.model_copy(update=laws)

    @property
    def follow_time(self) -> bool:
        """Whether the pressure at the end of a step depends on the steps that lead to it."""
        return self.solid is None and (self.rate.follows_motion or self.relaxation is not None)

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric: with Vf0 / J, area changes a pressure that does no work on it."""
        by_volume = self.solid is None and self.volume_fraction == "volume"
        return all(law.symmetric for law in self.chosen) and not by_volume

    @property
    def stiffness(self) -> float:
        """Largest modulus in Pa."""
        return float(self.in_plane.stiffness if self.solid is None else self.solid.stiffness)

    def compaction_tangent(self, initial_volume_fraction: float, speed: float) -> float:
        """Tangent in Pa across the thickness at `PENALTY_VOLUME_FRACTION` and a closing speed of the process (m/s)."""
        if self.solid is not None:
            return self.solid.stiffness
        vf, limit = PENALTY_VOLUME_FRACTION, self.compaction.packing_limit
        if not initial_volume_fraction < vf < limit:
            vf = (initial_volume_fraction + limit) / 2
        tangent = self.compaction.tangent(vf, initial_volume_fraction)
        return float(tangent * max(self.rate.factor(speed), self.rate.factor(0.0)))
