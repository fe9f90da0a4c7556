"""A measured table as a curve: monotone and continuously differentiable, straight beyond its ends.

It holds for numbers, numpy arrays and UFL alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import ClassVar, Literal, Self

import numpy as np
import ufl
from pydantic import model_validator

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.laws.law import is_symbolic, positive
from ncf_fenicsx.parameters.kinds import Constants, Kind, impossible

LEAST_END_SLOPE = 0.1
"""Slope at the ends of a table over the secant there: a flat end would leave what lies beyond it without stiffness."""


@dataclass(frozen=True)
class MonotoneCubic:
    """Cubic of Hermite through the nodes, with the slopes of Fritsch and Carlson 1980, as scipy's PCHIP has them.

    Args:
        x: nodes, ascending.
        y: values there, ascending too.
        ends: how the curve goes on beyond its nodes: "straight", with the slopes there, or "level".
        odd: whether it begins at the origin and has the slope there of an odd function, that to its next node.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    ends: Literal["straight", "level"] = "straight"
    odd: bool = False

    @classmethod
    @lru_cache(maxsize=256)
    def through(
        cls, x: tuple[float, ...], y: tuple[float, ...], ends: Literal["straight", "level"] = "straight"
    ) -> Self:
        """The curve through nodes; made once, for each evaluation of a law asks for it."""
        return cls(x, y, ends)

    @classmethod
    @lru_cache(maxsize=256)
    def from_origin(cls, x: tuple[float, ...], y: tuple[float, ...]) -> Self:
        """Half of the odd curve through the origin, positive nodes, and both mirrored."""
        return cls((0.0, *x), (0.0, *y), odd=True)

    @cached_property
    def slopes(self) -> list[float]:
        """Slopes at the nodes."""
        from scipy.interpolate import PchipInterpolator  # slow to load, and for tables only

        x, y = np.array(self.x), np.array(self.y)
        if self.odd:
            x, y = (np.concatenate([-values[:0:-1], values]) for values in (x, y))
        slope = PchipInterpolator(x, y).derivative()(x)[-len(self.x) :]
        secant = np.diff(self.y) / np.diff(self.x)
        if self.ends == "level":
            slope[[0, -1]] = 0.0
        else:
            slope[[0, -1]] = np.maximum(slope[[0, -1]], LEAST_END_SLOPE * secant[[0, -1]])
        return [float(value) for value in slope]

    def __call__(self, at: Expression) -> Expression:
        """The curve."""
        (value, first, square, cube), reach = self._piece(at)
        return value + reach * (first + reach * (square + reach * cube))

    def integral(self, at: Expression) -> Expression:
        """Integral of the curve from its first node."""
        (value, first, square, cube, area), reach = self._piece(at, self._areas)
        return area + reach * (value + reach * (first / 2 + reach * (square / 3 + reach * cube / 4)))

    def _piece(self, at: Expression, *more: list[float]) -> tuple[list[Expression], Expression]:
        """Coefficients of the cubic that holds at a place, and the distance from where it begins.

        Chosen by place, not summed over the pieces: a derivative in UFL is then that of one cubic.

        Args:
            at: the place.
            more: other numbers of each piece, to choose too.
        """
        starts = [self.x[0], *self.x]
        columns = [*(list(column) for column in zip(*self._pieces, strict=True)), *more]
        if is_symbolic(at):
            return [_chosen(at, self.x, column) for column in columns], at - _chosen(at, self.x, starts)
        number = np.searchsorted(self.x, at, side="right")
        return [np.array(column)[number] for column in columns], at - np.array(starts)[number]

    @cached_property
    def _pieces(self) -> list[tuple[float, float, float, float]]:
        """Coefficients of each power of the distance, of what lies before the nodes, between them, and behind."""
        x, y, slope = self.x, self.y, self.slopes
        pieces = [(y[0], slope[0], 0.0, 0.0)]
        for i, length in enumerate(np.diff(x)):
            secant = (y[i + 1] - y[i]) / length
            square = (3 * secant - 2 * slope[i] - slope[i + 1]) / length
            cube = (slope[i] + slope[i + 1] - 2 * secant) / length**2
            pieces.append((y[i], slope[i], float(square), float(cube)))
        return [*pieces, (y[-1], slope[-1], 0.0, 0.0)]

    @cached_property
    def _areas(self) -> list[float]:
        """Integral from the first node to where each piece begins."""
        areas = [0.0]
        for length, (value, first, square, cube) in zip(np.diff(self.x), self._pieces[1:], strict=False):
            area = length * (value + length * (first / 2 + length * (square / 3 + length * cube / 4)))
            areas.append(areas[-1] + float(area))
        return [0.0, *areas]

    def split(self, at: Expression) -> list[Expression]:
        """A number held to each interval of the table, and to what lies below and above it."""
        x = self.x
        inner = [low + between(at - low, high - low) for low, high in pairwise(x)]
        return [at - positive(at - x[0]), *inner, x[-1] + positive(at - x[-1])]


def _chosen(at: Expression, x: Sequence[float], values: Sequence[float]) -> Expression:
    """The value of the piece that a place is in: one more than nodes, and no condition where neighbours are equal."""
    chosen = ufl.as_ufl(values[0])
    for node, before, value in zip(x, values, values[1:], strict=False):
        chosen = chosen if value == before else ufl.conditional(ufl.ge(at, node), value, chosen)
    return chosen


def between(number: Expression, length: float) -> Expression:
    """The number, held to [0, length]."""
    return positive(number) - positive(number - float(length))


class Tabulated(Kind):
    """A law given by the columns of a table: as many entries in each, ascending, and compiled into the forms.

    Attributes:
        columns: names of the fields that are the table.
    """

    columns: ClassVar[tuple[str, ...]]

    @model_validator(mode="after")
    def _columns_ascend(self) -> Self:
        count = len(getattr(self, self.columns[0]))
        for name in self.columns:
            values = list(getattr(self, name))
            if len(values) != count:
                raise impossible(name, values, f"expected {count} entries, as {self.columns[0]} has")
            if np.any(np.diff(values) <= 0):
                raise impossible(name, values, "expected ascending numbers")
        return self

    def with_constants(self, constants: Constants) -> Self:
        """Copy with constants, but the table itself: the curve through it is made of numbers."""
        table = {name: getattr(self, name) for name in self.columns}
        return super().with_constants(constants).model_copy(update=table)
