"""[laws.rate]: factor on the compaction pressure that depends on speed."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import CompactionStep, Conditions, Law, Measured, positive, real
from ncf_fenicsx.laws.monotone_cubic import MonotoneCubic, Tabulated
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveLength, PositiveSpeed, PositiveStress

PositiveFactor = Annotated[float, Field(gt=0)]


class RateLaw(Law):
    """Factor on the compaction pressure that depends on speed."""

    family = "rate"

    @abstractmethod
    def factor(self, speed: Expression) -> Expression:
        """Dimensionless factor at a closing speed (m/s, negative in opening)."""

    def speed(self, step: CompactionStep) -> Expression:
        """Closing speed in m/s that the factor is taken at: that of the process."""
        return step.process_speed

    @property
    def follows_motion(self) -> bool:
        """Whether the speed is that of the fabric, which changes within a step."""
        return type(self).speed is not RateLaw.speed

    def apply(self, step: CompactionStep, slow: Expression) -> Expression:
        """Pressure in Pa at the step's speed from that of slow loading.

        Speed acts on pressure alone: were the tension of fabric pulled apart larger in closing than in opening, a cycle
        would create energy.
        """
        at_rest = self.factor(0.0)
        return at_rest * slow + (self.factor(self.speed(step)) - at_rest) * positive(slow)


class ClosingSpeedRate(RateLaw):
    """A factor by the speed at which the fabric closes at each place, or by that of the tool."""

    feed: Literal["process", "local"] = parameter(
        "local", description="speed: the closing speed of the fabric at each point, or that of the process, the tool's"
    )
    reference_thickness: PositiveLength = parameter(
        "4 mm", description="thickness of the specimens of the fit: local closing speed = this times -d(lambda_3)/dt"
    )

    def speed(self, step: CompactionStep) -> Expression:
        """Closing speed in m/s: of the process, or the reference thickness times -d(Vf0 / Vf)/dt.

        Vf0 / Vf is lambda_3, or J where Vf goes by volume. Not its logarithm: a specimen of the reference thickness
        then closes at the speed of the cross-head throughout, and the law gives back the curves it was fitted to.
        """
        if self.feed == "process":
            return step.process_speed
        closed = step.initial_volume_fraction * (1 / step.old_volume_fraction - 1 / step.volume_fraction)
        return self.reference_thickness * closed * step.inverse_time_step

    @property
    def follows_motion(self) -> bool:
        """With a local speed."""
        return self.feed == "local"


class KellyRate(ClosingSpeedRate):
    """A(v) / A(v_ref), A(v) = R - [alpha1 (v / v_ref)^alpha2 + (R - 1)^-alpha3]^(-1/alpha3), R = sigma_inf / sigma_0.

    The paper prints the exponent +1/alpha3, which falls with speed, turns negative and is not 1 at rest; with -1/alpha3
    A(0) = 1 and A(infinity) = R, as the paper defines sigma_0 and sigma_inf. The paper multiplies by A(v) a stress that
    was fitted at v_ref, which counts A(v_ref) twice; the default divides by it. In opening the factor is that of rest,
    the smallest (not so as printed): no cycle then gives more work than was put in, and with alpha2 > 1 the change is
    smooth.
    """

    kind = "kelly"
    fitted = ("alpha1", "alpha2")  # a handful of speeds tells two of four numbers
    alpha1: float = parameter(0.1254, gt=0, description="factor of the speed term")
    alpha2: float = parameter(3.2054, gt=1, description="exponent of the speed")
    alpha3: float = parameter(1.6507, gt=0, description="exponent of the transition")
    sigma_0: PositiveStress = parameter("23726 Pa", description="stress at the lowest speed")
    sigma_inf: PositiveStress = parameter("85829 Pa", description="stress at the highest speed")
    v_ref: PositiveSpeed = parameter("2 mm/min", description="speed at which the compaction law was fitted")
    exponent: Literal["corrected", "as_printed"] = parameter(
        "corrected", description="-1/alpha3, or +1/alpha3 as printed"
    )
    normalised: Literal["v_ref", "lowest_speed"] = parameter(
        "v_ref", description="A(v) / A(v_ref), or A(v) itself, relative to the stress at the lowest speed, as printed"
    )

    @model_validator(mode="after")
    def _stress_grows_with_speed(self) -> Self:
        if self.sigma_inf <= self.sigma_0:
            raise impossible("sigma_inf", self.sigma_inf, f"expected more than sigma_0 = {self.sigma_0:g} Pa")
        return self

    def first_guess(self, measured: Measured) -> Self:
        """With v_ref among the speeds of the tests."""
        speeds = self.reference_thickness * np.array(measured.closing_rates)
        if speeds[0] <= self.v_ref <= speeds[-1]:
            return self
        return self.model_copy(update={"v_ref": float(np.exp(np.mean(np.log(speeds))))})

    def check(self, conditions: Conditions) -> None:
        """Raise where the factor is negative or beyond numbers, at rest, at v_ref or at a speed of the process."""
        speeds = conditions.closing_speeds if self.feed == "process" else ()
        for speed in (0.0, self.v_ref, *speeds):
            factor = real(self.growth, speed)
            if not 0 < factor < math.inf:
                found = f"it is {factor:.3g} at {6e4 * speed:.3g} mm/min"
                raise impossible("laws.rate.exponent", self.exponent, f"expected a positive factor; {found}")

    def growth(self, speed: Expression) -> Expression:
        """A(v), dimensionless: 1 at rest and in opening, sigma_inf / sigma_0 at infinite speed."""
        ratio, sign = self.sigma_inf / self.sigma_0, 1 if self.exponent == "as_printed" else -1
        speed_term = self.alpha1 * (positive(speed) / self.v_ref) ** self.alpha2
        return ratio - (speed_term + (ratio - 1) ** (-self.alpha3)) ** (sign / self.alpha3)

    def factor(self, speed: Expression) -> Expression:
        """A(v) / A(v_ref), or A(v)."""
        return self.growth(speed) / (self.growth(self.v_ref) if self.normalised == "v_ref" else 1.0)

    def caution(self, conditions: Conditions) -> str | None:
        """The printed exponent makes the stress fall with speed, and negative from a speed on."""
        del conditions
        if self.exponent == "corrected":
            return None
        ratio = self.sigma_inf / self.sigma_0
        zero = self.v_ref * ((ratio**self.alpha3 - (ratio - 1) ** -self.alpha3) / self.alpha1) ** (1 / self.alpha2)
        return (
            f"the factor as printed falls with speed and is negative above {6e4 * zero:.3g} mm/min; it is largest in "
            "opening, so that cycles create energy"
        )


class RateTable(Tabulated, ClosingSpeedRate):
    """A measured factor over speed: monotone and continuously differentiable, level beyond the table and at rest.

    A factor of 1 belongs to the speed at which the compaction law was fitted.
    """

    kind = "table"
    columns = ("closing_speed", "factors")
    fitted = ("factors",)
    closing_speed: tuple[PositiveSpeed, ...] = parameter(
        ("1 mm/min", "2 mm/min", "5 mm/min"), min_length=2, description="closing speeds, ascending"
    )
    factors: tuple[PositiveFactor, ...] = parameter(
        (0.6632, 1.0, 1.8404), min_length=2, description="factor at each, ascending (the default: Eq. 4 at its speeds)"
    )

    def first_guess(self, measured: Measured) -> Self:
        """Nodes at the speeds of the tests; the factor is 1 at the middle one."""
        speeds = self.reference_thickness * np.array(measured.closing_rates)
        middle = len(speeds) // 2
        factors = (speeds / speeds[middle]) ** 0.5
        columns = {"closing_speed": speeds, "factors": factors}
        return self.model_copy(update={name: tuple(map(float, column)) for name, column in columns.items()})

    def factor(self, speed: Expression) -> Expression:
        """Interpolated factor."""
        return MonotoneCubic.through(self.closing_speed, self.factors, "level")(speed)

    def caution(self, conditions: Conditions) -> str | None:
        """Speeds of the process at which nothing was measured."""
        low, high = self.closing_speed[0], self.closing_speed[-1]
        beyond = [speed for speed in conditions.closing_speeds if speed > 0 and not low <= speed <= high]
        if self.feed != "process" or not beyond:
            return None
        measured = f"{6e4 * low:.3g} to {6e4 * high:.3g} mm/min"
        return f"a tool moves at {6e4 * beyond[0]:.3g} mm/min, and the table is level beyond {measured}"


class NoRate(RateLaw):
    """No dependence on speed."""

    kind = "none"
    fitted = ()

    def factor(self, speed: Expression) -> Expression:
        """1, whatever the speed."""
        del speed
        return 1.0
