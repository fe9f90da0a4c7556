"""What every law owes the rest of the program."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.parameters.kinds import Kind


@dataclass(frozen=True)
class Conditions:
    """What a scene uses its laws for, as far as a law has to be checked against it.

    Attributes:
        initial_volume_fraction: Vf0.
        elements_through: elements through each layer, from the bottom up.
        closing_speeds: speeds of the tools downwards in m/s, one for each segment of their paths.
        fibre_modulus: largest modulus in the plane of the fibres in Pa.
        shear_modulus: transverse shear modulus of the undeformed fabric in Pa.
        initial_pressure: compaction pressure of the undeformed fabric in Pa.
        has_fibres: whether the layers are fabric, not a solid.
        layer_thickness: of a layer in m.
    """

    initial_volume_fraction: float
    elements_through: tuple[int, ...]
    closing_speeds: tuple[float, ...]
    fibre_modulus: float
    shear_modulus: float
    initial_pressure: float
    has_fibres: bool
    layer_thickness: float

    @property
    def layers(self) -> int:
        """Number of layers."""
        return len(self.elements_through)


@dataclass(frozen=True)
class Measured:
    """What compaction tests hold, as far as a law begins its fit from it.

    Attributes:
        volume_fraction: Vf of the press, all tests together, ascending.
        pressure: in Pa at each, smoothed so that it ascends too.
        initial_volume_fraction: Vf0.
        closing_rates: in 1/s, one for each rate at which tests were made, ascending.
        durations: the shortest and the longest time in s that the tests tell of.
    """

    volume_fraction: NDArray[np.float64]
    pressure: NDArray[np.float64]
    initial_volume_fraction: float
    closing_rates: tuple[float, ...]
    durations: tuple[float, float]


class Law(Kind):
    """A constitutive law."""

    symmetric: ClassVar[bool] = True
    """Whether the law's tangent is symmetric."""
    fitted: ClassVar[tuple[str, ...] | None] = None
    """Numbers that the usual tests of the law tell, and a fit frees; None for all of them.

    ``branches.share`` is that number of each entry of a list.
    """

    def first_guess(self, measured: Measured) -> Self:
        """A law of this kind for a fit to begin from."""
        del measured
        return self

    @property
    def data_range(self) -> tuple[float, float] | None:
        """Smallest and largest Vf of the data that the law is given by; None of a formula."""
        return None

    def check(self, conditions: Conditions) -> None:
        """Raise `kinds.impossible` if the law does not go with the rest of the scene."""

    def caution(self, conditions: Conditions) -> str | None:
        """What a user of this law has to know before a run, in a sentence."""
        del conditions
        return None


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


def number(expression: Expression) -> float:
    """Value of an expression of numbers, without fields."""
    return float(apply_derivatives(apply_algebra_lowering(ufl.as_ufl(expression)))(()))


def real(formula: Callable[[float], Any], argument: float) -> float:
    """Value of a formula, not a number where it has no real one."""
    try:
        value = formula(argument)
    except ArithmeticError:
        return math.nan
    return math.nan if isinstance(value, complex) else float(value)


def larger(one: Expression, other: Expression) -> Expression:
    """The larger of two numbers, arrays or expressions."""
    return ufl.max_value(one, other) if is_symbolic(one, other) else np.maximum(one, other)


def smaller(one: Expression, other: Expression) -> Expression:
    """The smaller of two numbers, arrays or expressions."""
    return ufl.min_value(one, other) if is_symbolic(one, other) else np.minimum(one, other)


def tanh(value: Expression) -> Expression:
    """Hyperbolic tangent of a number, an array or an expression."""
    return ufl.tanh(value) if is_symbolic(value) else np.tanh(value)


def is_symbolic(*values: Expression) -> bool:
    """Whether one of some values is an expression of UFL."""
    return any(isinstance(value, Expr) for value in values)


def positive(value: Expression) -> Expression:
    """max(value, 0)."""
    return (value + abs(value)) / 2
