"""[laws.compaction]: pressure across the thickness over the fibre volume fraction, in monotone loading.

Formulas use Python's operators only, so they hold for numbers, numpy arrays and UFL alike.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from itertools import product
from typing import Annotated, Literal, Self

import numpy as np
import ufl
from pydantic import Field

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import Conditions, Law, Measured, number, positive, real
from ncf_fenicsx.laws.monotone_cubic import MonotoneCubic, Tabulated
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveStress, Stress

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)
PANELS = 16
MOST_NODES, ROWS_A_NODE = 8, 10
"""Nodes of a table that is fitted, and measured rows that each of them needs."""
BELOW = 1 - 1e-6
"""Where such a table begins, over Vf0: round-off must not put Vf0 beyond it."""
WIDEST = math.log(1e6)
"""Logarithm of the factor within which the first number of a law is looked for."""

VolumeFraction = Annotated[float, Field(gt=0, lt=1)]


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

    def first_guess(self, measured: Measured) -> Self:
        """The law whose first fitted number gives it the largest pressure that was measured."""
        from scipy.optimize import brentq  # slow to load, and for calibration only

        names = self.fitted or tuple(name for name, value in self if isinstance(value, float))
        if not names:
            return self
        first, vf0 = float(getattr(self, names[0])), measured.initial_volume_fraction
        vf, goal = float(measured.volume_fraction[-1]), float(measured.pressure[-1])

        def off(factor: float) -> float:
            law = self.model_copy(update={names[0]: first * math.exp(factor)})
            return real(lambda at: law.pressure(at, vf0), vf) - goal

        if not off(-WIDEST) * off(WIDEST) < 0:
            return self
        return self.model_copy(update={names[0]: first * math.exp(brentq(off, -WIDEST, WIDEST))})

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


class Exponential(CompactionLaw):
    """sigma_beta(Vf) = beta1^(beta2 Vf - beta3) + beta4, with a choice of what its tensile toe becomes.

    As printed, the paper's constants give tension (-962 Pa) in the undeformed fabric (Vf0 = 0.398) and up to
    Vf = 0.4299: it would shrink by itself. ``shift`` takes the stress at Vf0 off, so that the undeformed fabric is
    free of stress; ``clip`` keeps the printed curve where it presses and lays its toe smoothly to zero; ``raw`` is
    the curve as printed.
    """

    kind = "exponential"
    fitted = ("beta2", "beta3")  # a shift cancels beta4, and these two make up for the base
    beta1: PositiveStress = parameter("96605 Pa", description="base of the exponential")
    beta2: float = parameter(1.5238, gt=0, description="factor of Vf in the exponent")
    beta3: float = parameter(-0.0176, description="offset of the exponent")
    beta4: Stress = parameter("-2254 Pa", description="additive constant, cancelled by the shift")
    toe: Literal["shift", "clip", "raw"] = parameter(
        "shift", description="tensile toe of the printed curve: shifted to zero at Vf0, clipped, or raw"
    )
    smoothing: PositiveStress = parameter("100 Pa", description="stress over which clip rounds the corner")

    def first_guess(self, measured: Measured) -> Self:
        """With the offset of the exponent that gives the largest pressure measured."""
        least = float(self.smoothing)
        found = self.pressure(float(measured.volume_fraction[-1]), measured.initial_volume_fraction)
        missing = np.log(measured.pressure[-1] / max(float(found), least)) / np.log(self.beta1)
        return self.model_copy(update={"beta3": self.beta3 - float(missing)})

    def as_printed(self, volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) of Eq. 3 in Pa."""
        return self.beta1 ** (self.beta2 * volume_fraction - self.beta3) + self.beta4

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """sigma_beta(Vf) in Pa; shifted or clipped, it is zero at Vf0."""
        curve = {"shift": self.as_printed, "clip": self._clipped, "raw": self.as_printed}[self.toe]
        at_rest = 0.0 if self.toe == "raw" else curve(initial_volume_fraction)
        return curve(volume_fraction) - at_rest

    def _clipped(self, volume_fraction: Expression) -> Expression:
        """max(sigma_beta, 0) with its corner a hyperbola: smooth, and never without a slope."""
        stress = self.as_printed(volume_fraction)
        return (stress + (stress**2 + 4 * self.smoothing**2) ** 0.5) / 2


class Power(CompactionLaw):
    """A (Vf^b - Vf0^b): the field's A Vf^b (Robitaille and Gauvin 1998), made stress-free at Vf0 (as Toll 1998 has it).

    The defaults meet the paper's shifted curve at Vf 0.50 and 0.60.
    """

    kind = "power"
    fitted = ("scale", "exponent")
    scale: PositiveStress = parameter("6.97455 MPa", description="factor A: the stress that Vf = 1 would give")
    exponent: float = parameter(9.93265, ge=1, description="exponent b; 7 to 15.5 for tows")

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """A (Vf^b - Vf0^b) in Pa."""
        return self.scale * (volume_fraction**self.exponent - initial_volume_fraction**self.exponent)


class OffsetPower(CompactionLaw):
    """(k (Vf - Vf0))^n, as fitted to stacks of carbon and flax (three-parameter law with k, n and Vf0).

    Its slope is zero at Vf0, where a free layer would have no stiffness at all: Vf - Vf0 is rounded off at the corner
    by a hyperbola of width ``toe``. The defaults meet the paper's shifted curve at Vf 0.50 and 0.60.
    """

    kind = "offset_power"
    fitted = ("k", "n")
    k: float = parameter(225.8515, gt=0, description="factor k in Pa^(1/n)")
    n: float = parameter(2.791795, ge=1, description="exponent n")
    toe: float = parameter(0.005, gt=0, lt=0.1, description="Vf over which the corner at Vf0 is rounded")

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """(k x)^n - (k toe)^n in Pa, x the rounded Vf - Vf0, equal to toe at Vf0."""
        gain = volume_fraction - initial_volume_fraction
        rounded = (gain + (gain**2 + 4 * self.toe**2) ** 0.5) / 2
        return (self.k * rounded) ** self.n - (self.k * self.toe) ** self.n


class Gutowski(CompactionLaw):
    """As (sqrt(Vf / Vf0) - 1) / (sqrt(Va / Vf) - 1)^4 (Gutowski 1987): without bound as Vf nears Va.

    Below Vf0, where the formula has an extremum, the curve goes on straight. The default of As meets the paper's
    shifted curve at Vf 0.60.
    """

    kind = "gutowski"
    fitted = ("spring", "limit")
    spring: PositiveStress = parameter("107.906 Pa", description="spring constant As")
    limit: float = parameter(0.80, gt=0, le=1, description="largest possible Vf, Va")

    def check(self, conditions: Conditions) -> None:
        """Raise if the fabric starts beyond the limit."""
        initial = conditions.initial_volume_fraction
        if self.limit <= initial:
            raise impossible("laws.compaction.limit", self.limit, f"expected above Vf0 = {initial:.4g}")

    @property
    def packing_limit(self) -> float:
        """Va."""
        return self.limit

    def first_guess(self, measured: Measured) -> Self:
        """With a limit beyond all that was measured."""
        limit = min(0.98, max(0.8, float(measured.volume_fraction[-1]) + 0.1))
        return super(Gutowski, self.model_copy(update={"limit": limit})).first_guess(measured)

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Pressure in Pa, straight below Vf0."""
        gain = volume_fraction - initial_volume_fraction
        vf = initial_volume_fraction + positive(gain)
        bent = ((vf / initial_volume_fraction) ** 0.5 - 1) / ((self.limit / vf) ** 0.5 - 1) ** 4
        slope = 1 / (2 * initial_volume_fraction) / ((self.limit / initial_volume_fraction) ** 0.5 - 1) ** 4
        return self.spring * (bent - slope * positive(-gain))


class Table(Tabulated, CompactionLaw):
    """Monotone, continuously differentiable cubic through (Vf, pressure), moved to zero at Vf0, straight at its ends.

    Slopes are those of Fritsch and Carlson 1980, as scipy's PCHIP has them.
    """

    kind = "table"
    columns = ("volume_fraction", "stress")
    fitted = ("stress",)
    volume_fraction: tuple[VolumeFraction, ...] = parameter(
        (0.38, 0.40, 0.42, 0.46, 0.50, 0.55, 0.60, 0.65), min_length=2, description="fibre volume fractions, ascending"
    )
    stress: tuple[Stress, ...] = parameter(
        ("-0.35 kPa", "0.045 kPa", "0.605 kPa", "2.527 kPa", "6.396 kPa", "17.142 kPa", "42.908 kPa", "104.689 kPa"),
        min_length=2,
        description="pressure at each, ascending",
    )

    def caution(self, conditions: Conditions) -> str | None:
        """The table is moved where its data is not zero at Vf0."""
        moved = self._curve(conditions.initial_volume_fraction)
        if abs(moved) < 1e-3 * max(map(abs, self.stress)):
            return None
        return f"the table is moved by {-moved:.4g} Pa, for the undeformed fabric to be free of stress"

    @property
    def data_range(self) -> tuple[float, float] | None:
        """Vf of the first and last entry."""
        return self.volume_fraction[0], self.volume_fraction[-1]

    def first_guess(self, measured: Measured) -> Self:
        """Nodes at Vf0, without pressure, and where equal shares of the measured rows lie between them."""
        vf, initial = measured.volume_fraction, measured.initial_volume_fraction
        count = min(MOST_NODES, max(len(vf) // ROWS_A_NODE, 1))
        nodes = np.unique(np.quantile(vf[vf > initial], np.arange(1, count + 1) / count))
        stress = np.maximum(np.interp(nodes, vf, measured.pressure), 0.0)
        rising = np.maximum.accumulate(stress) + 1e-3 * stress[-1] * np.arange(1, len(nodes) + 1)
        table = {"volume_fraction": (BELOW * initial, *nodes.tolist()), "stress": (0.0, *rising.tolist())}
        return self.model_copy(update=table)

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Interpolated pressure less that at Vf0, in Pa."""
        return self._curve(volume_fraction) - self._curve(initial_volume_fraction)

    @property
    def _curve(self) -> MonotoneCubic:
        return MonotoneCubic.through(self.volume_fraction, self.stress)

    def energy(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Work of compaction in J/m3, integrated interval by interval."""
        pairs = zip(self._curve.split(initial_volume_fraction), self._curve.split(volume_fraction), strict=True)
        return sum(self.work_between(start, end, initial_volume_fraction) for start, end in pairs)
