"""What every law owes the rest of the program."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar

import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives

from ncf_fenicsx.kinds import Part
from ncf_fenicsx.laws.kinematics import Expression


class Law(Part):
    """A constitutive law."""

    symmetric: ClassVar[bool] = True
    """Whether the law's tangent is symmetric."""

    def check(self, scene: Any) -> None:
        """Raise `parts.impossible` if the law does not go with the rest of the scene."""

    def caution(self, scene: Any) -> str | None:
        """What a user of this law in a scene has to know before a run, in a sentence."""
        del scene
        return None


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
