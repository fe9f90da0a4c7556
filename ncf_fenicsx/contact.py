"""Contact of the fabric's face with a rigid tool: gap to pressure to residual. Knows no tool and no law."""

from __future__ import annotations

from typing import Any

import ufl

from ncf_fenicsx.kinematics import Expression

AT_NODES = {"quadrature_rule": "vertex", "quadrature_degree": 1}
"""Contact acts at nodes, each with its share of the reference area: no over-constraint, no pressure checkerboard."""


def penalty_pressure(gap: Expression, stiffness: Expression) -> Expression:
    """Pressure (Pa, per reference area) on a face that penetrates: stiffness * max(-gap, 0)."""
    return ufl.conditional(ufl.lt(gap, 0), -stiffness * gap, 0)


def penalty_work(gap: Expression, stiffness: Expression, displacement: Any, variation: Any, face: Any) -> ufl.Form:
    """Virtual work (J) of the contact pressure: -pressure * variation of the gap, over a face.

    The direction of the force is the derivative of the gap, the current normal of the tool.

    Args:
        gap: signed distance of the current points from the tool in m, negative in penetration.
        stiffness: penalty in Pa/m.
        displacement: field the gap depends on.
        variation: test function.
        face: UFL measure of the reference face.
    """
    return -penalty_pressure(gap, stiffness) * ufl.derivative(gap, displacement, variation) * face(metadata=AT_NODES)
