"""Rate factor of the compaction stress (paper, Eq. 4, after Kelly), and the scene's word for having none."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from ncf_fenicsx.contracts import RateLaw
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.parts import parameter
from ncf_fenicsx.units import PositiveSpeed, PositiveStress


class KellyRate(RateLaw):
    """A(v) / A(v_ref), A(v) = R - [alpha1 (v / v_ref)^alpha2 + (R - 1)^-alpha3]^(-1/alpha3), R = sigma_inf / sigma_0.

    The paper prints the exponent +1/alpha3, which falls with speed, turns negative and is not 1 at rest; with -1/alpha3
    A(0) = 1 and A(infinity) = R, as the paper defines sigma_0 and sigma_inf. The compaction law was fitted at v_ref,
    so the factor is normalised there.
    """

    kind = "kelly"
    alpha1: float = parameter(0.1254, gt=0, description="factor of the speed term")
    alpha2: float = parameter(3.2054, gt=1, description="exponent of the speed")
    alpha3: float = parameter(1.6507, gt=0, description="exponent of the transition")
    sigma_0: PositiveStress = parameter("23726 Pa", description="stress at the lowest speed")
    sigma_inf: PositiveStress = parameter("85829 Pa", description="stress at the highest speed")
    v_ref: PositiveSpeed = parameter("2 mm/min", description="speed at which the compaction law was fitted")

    @model_validator(mode="after")
    def _stress_grows_with_speed(self) -> Self:
        if self.sigma_inf <= self.sigma_0:
            raise ValueError(f"sigma_inf = {self.sigma_inf:g} Pa: expected more than sigma_0 = {self.sigma_0:g} Pa")
        return self

    def growth(self, speed: Expression) -> Expression:
        """A(v), dimensionless: 1 at rest, sigma_inf / sigma_0 at infinite speed."""
        ratio = self.sigma_inf / self.sigma_0
        speed_term = self.alpha1 * (speed / self.v_ref) ** self.alpha2
        return ratio - (speed_term + (ratio - 1) ** (-self.alpha3)) ** (-1 / self.alpha3)

    def factor(self, speed: Expression) -> Expression:
        """A(v) / A(v_ref)."""
        return self.growth(speed) / self.growth(self.v_ref)


class NoRate(RateLaw):
    """No dependence on speed."""

    kind = "none"

    def factor(self, speed: Expression) -> Expression:
        """1, whatever the speed."""
        del speed
        return 1.0
