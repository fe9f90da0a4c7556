"""Laws of compaction: pressure over fibre volume fraction, its rate, relaxation and unloading.

Their formulas use Python's operators only, so they hold for numbers, numpy arrays and UFL alike.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import ufl

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import Law, number

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)
PANELS = 16


@dataclass(frozen=True)
class CompactionStep:
    """What happens across the thickness at a point in a time step.

    Attributes:
        volume_fraction: Vf at the end of the step.
        old_volume_fraction: Vf at its start.
        initial_volume_fraction: Vf0.
        time_step: size of the step in s; the stack takes for ever to settle.
        inverse_time_step: its inverse in 1/s, 0 then.
        process_speed: speed at which the tool closes in on the fabric in m/s, negative where it leaves.
        loading: pressure in Pa of monotone loading over Vf, without effects of rate.
    """

    volume_fraction: Expression
    old_volume_fraction: Expression
    initial_volume_fraction: Expression
    time_step: Expression
    inverse_time_step: Expression
    process_speed: Expression
    loading: Callable[[Expression], Expression]


class CompactionLaw(Law):
    """Pressure of the fabric across its thickness in monotone loading, at the speed it was fitted at."""

    family = "compaction"

    @abstractmethod
    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Pressure in Pa per reference area, positive in compaction, growing with Vf."""

    @property
    def packing_limit(self) -> float:
        """Vf that the law cannot reach."""
        return 1.0

    def energy(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Work of compaction in J/m3: integral of pressure Vf0 / Vf^2 dVf from Vf0, by Gauss's rule on panels."""
        return self.work_between(initial_volume_fraction, volume_fraction, initial_volume_fraction)

    def work_between(self, start: Expression, end: Expression, initial_volume_fraction: Expression) -> Expression:
        """Integral of pressure Vf0 / Vf^2 dVf between two Vf, in J/m3."""
        half = (end - start) / (2 * PANELS)
        work = 0.0
        for panel, (point, weight) in product(range(PANELS), zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True)):
            vf = start + half * (2 * panel + 1 + float(point))
            density = self.pressure(vf, initial_volume_fraction) * initial_volume_fraction / vf**2
            work = work + half * float(weight) * density
        return work

    def tangent(self, volume_fraction: float, initial_volume_fraction: float) -> float:
        """-d pressure / d lambda_3 in Pa, with d Vf / d lambda_3 = -Vf^2 / Vf0."""
        vf = ufl.variable(ufl.as_ufl(volume_fraction))
        slope = ufl.diff(ufl.as_ufl(self.pressure(vf, initial_volume_fraction)), vf)
        return number(slope) * volume_fraction**2 / initial_volume_fraction


class RateLaw(Law):
    """Factor on the compaction pressure that depends on speed."""

    family = "rate"

    @abstractmethod
    def factor(self, speed: Expression) -> Expression:
        """Dimensionless factor at a closing speed (m/s, negative in opening)."""

    def speed(self, step: CompactionStep) -> Expression:
        """Closing speed in m/s that the factor is taken at: that of the process."""
        return step.process_speed

    def apply(self, step: CompactionStep, slow: Expression) -> Expression:
        """Pressure in Pa at the step's speed from that of slow loading.

        Speed acts on pressure alone: were the tension of fabric pulled apart larger in closing than in opening, a cycle
        would create energy.
        """
        at_rest = self.factor(0.0)
        return at_rest * slow + (self.factor(self.speed(step)) - at_rest) * positive(slow)


class StatefulLaw(Law):
    """A law that keeps states at quadrature points; they are trial until the step is accepted."""

    @abstractmethod
    def initial_states(self, initial_volume_fraction: float) -> dict[str, float]:
        """Names of the states with their values at the start."""

    @abstractmethod
    def updated_states(self, step: CompactionStep, old: dict[str, Expression]) -> dict[str, Expression]:
        """The states at the end of a step from those at its start."""

    @abstractmethod
    def pressure(self, step: CompactionStep, old: dict[str, Expression]) -> Expression:
        """Pressure in Pa at the end of a step from the states at its start."""


class UnloadingLaw(StatefulLaw):
    """Pressure without effects of rate, when the fabric opens and closes again."""

    family = "unloading"


class RelaxationLaw(StatefulLaw):
    """Pressure that decays in time, on top of the others."""

    family = "relaxation"


def positive(value: Expression) -> Expression:
    """max(value, 0)."""
    return (value + abs(value)) / 2
