"""A layer's own pressure at the nodes of its face: it does the work of the stress, and pushes no tool away."""

import numpy as np
import pytest
from assembled import assign, build

pytestmark = pytest.mark.two_ranks

LENGTH, ELEMENTS, THICKNESS = 40e-3, 8, 2e-3


def pressed(order, kind):
    """One layer without rate, membrane or bending to speak of, pressed evenly under a plate without a penalty."""
    problem, newton = build(
        {
            "stack": {
                "layers": 1,
                "thickness": f"{THICKNESS} m",
                "size": [f"{LENGTH} m", "5 mm"],
                "divisions": [ELEMENTS, 1],
                "grading": [0, 0],
                "order": order,
            },
            "laws": {"shear": {"modulus": "1e-3 Pa"}, "rate": {"kind": "none"}},
            "tool": {
                "kind": "plate",
                "penalty": "1 Pa/m",
                "contact": {"kind": kind},
                "path": [{"travel": ["0 mm", "0 mm", "-0.4 mm"], "speed": "1 mm/min"}],
            },
        }
    )
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], -0.2 * x[2]]))
    problem.contacts.refresh()
    return problem, newton


def stiffness(problem, newton, motion):
    """Second derivative along a motion of the work of all forces, in N/m."""
    u, residuals, size = problem.displacement.x.array, [], 1e-9
    centre = u.copy()
    for sign in (1, -1):
        assign(problem, lambda x, sign=sign: np.stack([0 * x[0], 0 * x[0], -0.2 * x[2] + sign * size * motion(x)]))
        problem.contacts.refresh()
        residuals.append(newton.evaluate_residual())
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], motion(x)]))
    along = u[: len(residuals[0])].copy()
    u[:] = centre
    work = float(along @ (residuals[0] - residuals[1])) / (2 * size)
    return problem.mesh.comm.allreduce(work)


def zigzag(x):
    """Up at every second column of vertices, down between, linear in each element and across the layer."""
    return np.cos(np.pi * x[0] * ELEMENTS / LENGTH) * x[2] / THICKNESS


@pytest.mark.parametrize(("order", "excess"), [(1, 0.0), (2, 0.3)])
def test_the_pressure_at_nodes_does_no_more_work_than_the_stress(order, excess):
    layer = stiffness(*pressed(order, "penalty"), zigzag)  # no contact: the plate is above, without a penalty
    both = stiffness(*pressed(order, "nitsche"), zigzag)
    assert layer > 0
    assert both > -(excess + 0.02) * layer
    assert both < 0.6 * layer


def test_an_even_motion_is_carried_by_the_own_pressure_alone():
    def even(x):
        return x[2] / THICKNESS

    layer, both = stiffness(*pressed(1, "penalty"), even), stiffness(*pressed(1, "nitsche"), even)
    assert abs(both) < 1e-6 * layer
