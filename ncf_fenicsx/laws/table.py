"""Compaction pressure from a table of measurements."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.interpolate import PchipInterpolator

from ncf_fenicsx.kinds import Symbols, impossible, parameter
from ncf_fenicsx.laws.compaction import CompactionLaw, positive
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import Stress

VolumeFraction = Annotated[float, Field(gt=0, lt=1)]
LEAST_END_SLOPE = 0.1
"""Of the outer secant: a curve that ended flat would leave the fabric beyond it without stiffness."""


class Table(CompactionLaw):
    """Monotone, continuously differentiable cubic through (Vf, pressure), moved to zero at Vf0, straight at its ends.

    Slopes are those of Fritsch and Carlson 1980, as scipy's PCHIP has them.
    """

    kind = "table"
    volume_fraction: tuple[VolumeFraction, ...] = parameter(
        (0.38, 0.40, 0.42, 0.46, 0.50, 0.55, 0.60, 0.65), min_length=2, description="fibre volume fractions, ascending"
    )
    stress: tuple[Stress, ...] = parameter(
        ("-0.35 kPa", "0.045 kPa", "0.605 kPa", "2.527 kPa", "6.396 kPa", "17.142 kPa", "42.908 kPa", "104.689 kPa"),
        min_length=2,
        description="pressure at each, ascending",
    )

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if len(self.volume_fraction) != len(self.stress):
            count = len(self.volume_fraction)
            raise impossible("stress", list(self.stress), f"expected {count} entries, as volume_fraction has")
        for name in ("volume_fraction", "stress"):
            if np.any(np.diff(getattr(self, name)) <= 0):
                raise impossible(name, list(getattr(self, name)), "expected ascending numbers")
        return self

    def caution(self, scene: Any) -> str | None:
        """The table is moved where its data is not zero at Vf0."""
        moved = self._curve(scene.stack.initial_volume_fraction)
        if abs(moved) < 1e-3 * max(map(abs, self.stress)):
            return None
        return f"the table is moved by {-moved:.4g} Pa, for the undeformed fabric to be free of stress"

    def with_symbols(self, symbols: Symbols) -> Self:
        """The table itself: its numbers are compiled into the forms."""
        del symbols
        return self

    def pressure(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Interpolated pressure less that at Vf0, in Pa."""
        return self._curve(volume_fraction) - self._curve(initial_volume_fraction)

    def _curve(self, vf: Expression) -> Expression:
        """Sum over the intervals of what the pressure gains in each, as far as Vf reaches into it."""
        x, y, slope = self.volume_fraction, self.stress, _slopes(self.volume_fraction, self.stress)
        curve = y[0] - slope[0] * positive(x[0] - vf) + slope[-1] * positive(vf - x[-1])
        for i, length in enumerate(np.diff(x)):
            reach = _between(vf - x[i], length)
            secant = (y[i + 1] - y[i]) / length
            square = (3 * secant - 2 * slope[i] - slope[i + 1]) / length
            cube = (slope[i] + slope[i + 1] - 2 * secant) / length**2
            curve = curve + reach * (slope[i] + reach * (square + reach * cube))
        return curve

    def energy(self, volume_fraction: Expression, initial_volume_fraction: Expression) -> Expression:
        """Work of compaction in J/m3, integrated interval by interval."""
        pairs = zip(self._split(initial_volume_fraction), self._split(volume_fraction), strict=True)
        return sum(self.work_between(start, end, initial_volume_fraction) for start, end in pairs)

    def _split(self, vf: Expression) -> list[Expression]:
        """Vf held to each interval of the table, and to what lies below and above it."""
        x = self.volume_fraction
        inner = [low + _between(vf - low, high - low) for low, high in pairwise(x)]
        return [vf - positive(vf - x[0]), *inner, x[-1] + positive(vf - x[-1])]


@cache
def _slopes(x: tuple[float, ...], y: tuple[float, ...]) -> list[float]:
    """Slopes at the nodes; made once, for each evaluation of the curve asks for them."""
    slope = PchipInterpolator(x, y).derivative()(x)
    secant = np.diff(y) / np.diff(x)
    slope[[0, -1]] = np.maximum(slope[[0, -1]], LEAST_END_SLOPE * secant[[0, -1]])
    return [float(value) for value in slope]


def _between(number: Expression, length: float) -> Expression:
    """The number, held to [0, length]."""
    return positive(number) - positive(number - float(length))
