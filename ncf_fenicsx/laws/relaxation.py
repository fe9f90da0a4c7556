"""[laws.relaxation]: pressure that decays in time, on top of the others."""

from __future__ import annotations

import math
from typing import Self

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import CompactionStep, Measured, StatefulLaw, tanh
from ncf_fenicsx.parameters.kinds import Settings, parameter
from ncf_fenicsx.parameters.units import PositiveTime


class RelaxationLaw(StatefulLaw):
    """Pressure that decays in time, on top of the others."""

    family = "relaxation"


DECADES = tuple({"share": 0.05, "time": f"{time} s"} for time in (1, 10, 100, 1000))
"""One branch a decade, all alike: in a hold the pressure falls by about as much in each decade of time."""


class Branch(Settings):
    """One branch: a spring and a dashpot in series."""

    share: float = parameter(0.2, gt=0, description="stress that relaxes, over the pressure of slow loading")
    time: PositiveTime = parameter("10 s", description="relaxation time")


class Maxwell(RelaxationLaw):
    """Adds sum_i share_i e_i, with d e_i/dt + e_i / time_i = dp/dt and p the pressure of loading at the present Vf.

    e = p - pi is what the pressure is ahead of its relaxed value pi. The branch stores share times the integral of
    (p' - pi) d(strain) from pi to p and dissipates share (p - pi)(strain(p) - strain(pi)) / time, never negative where
    the pressure grows with Vf: a cycle creates no energy. In a step, p is taken linear in time and the equation solved
    exactly: a hold decays as the exact solution at any step size, and else the error is of order two.
    """

    kind = "maxwell"
    fitted = ("branches.share",)
    branches: tuple[Branch, ...] = parameter(
        DECADES, min_length=1, description="branches; one a decade for the creep of fabric, along a logarithm of time"
    )

    def first_guess(self, measured: Measured) -> Self:
        """A branch for each decade of time that the tests tell of."""
        shortest, longest = measured.durations
        first, last = math.ceil(math.log10(3 * shortest)), max(math.floor(math.log10(longest)), 0)
        decades = range(min(first, last), last + 1)
        branches = tuple(Branch.model_validate({"share": 0.05, "time": f"{10.0**power} s"}) for power in decades)
        return self.model_copy(update={"branches": branches})

    def initial_states(self, initial_volume_fraction: float) -> dict[str, float]:
        """No stress to relax at the start."""
        del initial_volume_fraction
        return {f"relaxing_pressure_{number + 1}": 0.0 for number in range(len(self.branches))}

    def updated_states(self, step: CompactionStep, old: dict[str, Expression]) -> dict[str, Expression]:
        """e_i at the end of the step: exp(-h) e_i + (1 - exp(-h)) / h times the gain of p, h = time step / time_i."""
        gain = step.loading(step.volume_fraction) - step.loading(step.old_volume_fraction)
        states = {}
        for number, branch in enumerate(self.branches):
            name = f"relaxing_pressure_{number + 1}"
            h = step.time_step / branch.time
            half = tanh(h / 2)  # in place of exp: exact also where h is too small to tell 1 - exp(-h) from 0
            states[name] = (1 - half) / (1 + half) * old[name] + 2 * half / ((1 + half) * h) * gain
        return states

    def pressure(self, step: CompactionStep, old: dict[str, Expression]) -> Expression:
        """Sum of the branches' pressures in Pa."""
        states = self.updated_states(step, old).values()
        return sum(branch.share * state for branch, state in zip(self.branches, states, strict=True))
