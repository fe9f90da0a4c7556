"""[laws.unloading]: pressure without effects of rate, when the fabric opens and closes again."""

from __future__ import annotations

from typing import ClassVar

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import CompactionStep, Conditions, StatefulLaw, larger, smaller
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveStress

TINY = 1e-12


class UnloadingLaw(StatefulLaw):
    """Pressure without effects of rate, when the fabric opens and closes again."""

    family = "unloading"


class PermanentSet(UnloadingLaw):
    """p(Vf - c D (1 - u^m)), p the curve of loading, D = Vf_max - Vf0, u = (Vf - Vf_p) / (Vf_max - Vf_p) in [0, 1].

    Vf_max is the largest Vf reached, Vf_p = Vf0 + c D the Vf at which the unloaded fabric is free of stress. At Vf_max
    the curve meets that of loading, which is then followed further; below Vf_p it is that of the fabric stretched from
    Vf0, moved to Vf_p. Its work from Vf_p to Vf_max grows by less than that of loading as Vf_max grows, for any curve
    that rises from zero: no cycle creates energy.
    """

    kind = "permanent_set"
    fitted: ClassVar[tuple[str, ...] | None] = ("set_share", "exponent")
    set_share: float = parameter(0.5, ge=0, lt=1, description="c: share of the largest gain of Vf that stays")
    exponent: float = parameter(3.0, ge=1, description="m: the larger, the steeper the first drop")

    def check(self, conditions: Conditions) -> None:
        """Raise if the undeformed fabric is under stress: there is no loading from zero then."""
        if abs(conditions.initial_pressure) > 1e-6:
            found = f"it has {conditions.initial_pressure:.4g} Pa there"
            expected = f"expected a compaction law that is free of stress at Vf0; {found}"
            raise impossible("laws.unloading.kind", self.kind, expected)

    def initial_states(self, initial_volume_fraction: float) -> dict[str, float]:
        """The largest Vf is Vf0."""
        return {"largest_volume_fraction": initial_volume_fraction}

    def updated_states(self, step: CompactionStep, old: dict[str, Expression]) -> dict[str, Expression]:
        """Vf_max at the end of the step."""
        return {"largest_volume_fraction": larger(step.volume_fraction, old["largest_volume_fraction"])}

    def share(self, step: CompactionStep, largest_volume_fraction: Expression) -> Expression:
        """c: share of the largest gain of Vf that stays."""
        del step, largest_volume_fraction
        return self.set_share

    def pressure(self, step: CompactionStep, old: dict[str, Expression]) -> Expression:
        """Pressure in Pa."""
        vf, largest = step.volume_fraction, self.updated_states(step, old)["largest_volume_fraction"]
        gain, share = largest - step.initial_volume_fraction, self.share(step, largest)
        past_set = vf - step.initial_volume_fraction - share * gain
        u = past_set / larger((1 - share) * gain, TINY)
        u = larger(smaller(u, 1.0), 0.0)
        return step.loading(vf - share * gain * (1 - u**self.exponent))


class PressureSet(PermanentSet):
    """The same, with a share that grows with the largest pressure p_max of loading: 1 - (1 - c)^((p_max / p_ref)^k).

    It is c at p_ref, about c (p_max / p_ref)^k below, and never reaches 1. A larger share gives back less work, so that
    this creates no energy either.
    """

    kind = "pressure_set"
    fitted = ("set_share", "exponent", "pressure_exponent")
    pressure_exponent: float = parameter(0.5, gt=0, description="k: how the share grows with the largest pressure")
    reference_pressure: PositiveStress = parameter("10 kPa", description="p_ref: largest pressure at which it is c")

    def share(self, step: CompactionStep, largest_volume_fraction: Expression) -> Expression:
        """Share c at the largest pressure so far."""
        ratio = larger(step.loading(largest_volume_fraction) / self.reference_pressure, TINY)
        return 1 - (1 - self.set_share) ** (ratio**self.pressure_exponent)
