"""Whether a rigid surface starts in the stack: its distances from points, and how far it would have to move away."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.tools.rigid_surface import RigidSurface, Tool

Floats = NDArray[np.float64]

OPERATORS: dict[str, Callable[..., Any]] = {
    "Sum": operator.add,
    "Product": operator.mul,
    "Division": operator.truediv,
    "Power": operator.pow,
    "Abs": np.abs,
    "Sqrt": np.sqrt,
    "MaxValue": np.maximum,
    "MinValue": np.minimum,
    "Conditional": np.where,
    "LE": np.less_equal,
    "LT": np.less,
    "GE": np.greater_equal,
    "GT": np.greater,
    "EQ": np.equal,
    "NE": np.not_equal,
    "AndCondition": np.logical_and,
    "OrCondition": np.logical_or,
    "NotCondition": np.logical_not,
}
"""What the operators of UFL that surfaces are written in do with arrays."""


def distances(surface: RigidSurface, points: Floats) -> Floats:
    """Signed distances in m of points, given in m relative to the tip, without a form to compile.

    Args:
        surface: the rigid surface.
        points: shape (points, 3).
    """
    coordinates = [ufl.variable(0.0) for _ in range(3)]
    expression = ufl.as_ufl(surface.signed_distance(ufl.as_vector(coordinates)))
    known = {id(coordinate): points[:, axis] for axis, coordinate in enumerate(coordinates)}
    try:
        with np.errstate(invalid="ignore", divide="ignore"):  # in branches that are not taken
            return np.broadcast_to(_values(expression, known), len(points)).astype(float)
    except NotImplementedError:  # a tool of a user's own, in other operators: slower, point by point
        found = [surface.signed_distance(ufl.as_vector([float(value) for value in point])) for point in points]
        return np.array([float(ufl.as_ufl(value)(())) for value in found])


def _values(expression: Any, known: dict[int, Any]) -> Any:
    """Values of an expression; those of what has been worked out before are known, by identity."""
    if id(expression) not in known:
        known[id(expression)] = _worked_out(expression, known)
    return known[id(expression)]


def _worked_out(expression: Any, known: dict[int, Any]) -> Any:
    if isinstance(expression, ufl.classes.ScalarValue | ufl.classes.Zero):
        return float(expression)
    work = OPERATORS.get(type(expression).__name__)
    if work is None:
        raise NotImplementedError(type(expression).__name__)
    operands = [_values(operand, known) for operand in expression.ufl_operands]
    return reduce(work, operands) if work in (operator.add, operator.mul) else work(*operands)


def depth_at_start(
    surface: RigidSurface, tip: Floats, lowest_gap: Callable[[Floats], float], tolerance: float
) -> float:
    """How far (m) a surface would have to move away along z, for the undeformed fabric to be free of it.

    Args:
        surface: the rigid surface.
        tip: where its tip starts in m.
        lowest_gap: smallest signed distance in m of the fabric from the surface with its tip at some position (m).
        tolerance: depth in m that is none.
    """
    away = np.array([0.0, 0.0, 1.0 if isinstance(surface, Tool) else -1.0])
    moved = 0.0
    for _ in range(100):  # a distance is no longer than that along z: each move is short of the last, if at all
        depth = -lowest_gap(tip + moved * away)
        if depth <= tolerance:
            break
        moved += depth
    return moved


def check_depth(name: str, surface: RigidSurface, depth: float) -> None:
    """Raise a SceneError that says how far to raise a tool, or to lower a mould, that starts a depth (m) in the stack.

    Args:
        name: of the surface in the scene.
        surface: the rigid surface.
        depth: in m, as of `depth_at_start`.
    """
    if depth > 0:
        given, enough = 1e3 * surface.clearance, math.ceil(1e7 * (surface.clearance + depth)) / 1e4
        raise SceneError(
            f"{name}.clearance = {given:.6g} mm: it starts {1e3 * depth:.4g} mm inside the stack; "
            f"expected at least {enough:.6g} mm"
        )
