"""Buckling of a compressed layer on an elastic foundation, from the lowest mode of the tangent (Hetenyi 1946).

A strip of rigidity B per width on a foundation of stiffness k buckles under 2 sqrt(B k), in waves 2 pi (B / k)^(1/4)
long; n layers that slide on each other have n times that rigidity.
"""

import numpy as np
import pytest
from assembled import assign, build
from layers import everywhere
from scipy.optimize import brentq

pytestmark = pytest.mark.serial

THICKNESS, RIGIDITY, FOUNDATION, MEMBRANE = 0.5e-3, 5e-4, 1e6, 1e10
MODULUS = 12 * RIGIDITY / THICKNESS**3
LENGTH, PRESSED = 0.3, 1e-6


def strip(layers, divisions, order):
    """Layers that rest on a mould whose penalty is the foundation; nothing weighs."""
    return build(
        {
            "gravity": "0 m/s^2",
            "duration": "1 s",
            "stack": {
                "layers": layers,
                "thickness": f"{THICKNESS} m",
                "areal_density": "356.25 g/m^2",
                "size": [f"{LENGTH} m", "1 mm"],
                "divisions": [divisions, 1],
                "order": order,
                "grading": [0, 0],
                "sides": dict.fromkeys(("x_min", "x_max", "y_min", "y_max"), "symmetry"),
            },
            "laws": {
                "in_plane": {"modulus": f"{MEMBRANE} Pa", "poisson": 0.0},
                "bending": {"modulus": f"{MODULUS} Pa", "poisson": 0.0},
                "shear": {"modulus": "1 GPa"},
            },
            "mould": {"kind": "plate", "penalty": f"{FOUNDATION} Pa/m"},
        }
    )


def stiffness_under(problem, newton, force):
    """Lowest eigenvalue in N/m and its mode, with all layers in contact and under a force per width in N/m."""
    layers = problem.scene.stack.layers
    strain = force / (layers * MEMBRANE * THICKNESS)

    def pressed(x):
        layer = np.floor(x[2] / THICKNESS * (1 - 1e-9))
        return np.stack([-strain * x[0], 0 * x[0], -PRESSED * (layer + 1)])

    assign(problem, pressed)
    if layers > 1:  # faces of two layers have the same place
        upper = problem.contacts.layers[0].pairing.masters
        problem.displacement.x.array.reshape(-1, 3)[np.isin(problem.contacts.body.spaces.numbers, upper), 2] -= PRESSED
    problem.contacts.refresh()
    return newton.critical_mode()


@pytest.mark.parametrize(("layers", "divisions", "order"), [(1, 300, 1), (1, 120, 2), (2, 300, 1)])
def test_a_layer_on_a_foundation_buckles_under_its_critical_force(layers, divisions, order):
    problem, newton = strip(layers, divisions, order)
    rigidity = layers * RIGIDITY
    expected = 2 * np.sqrt(rigidity * FOUNDATION)
    critical = brentq(
        lambda force: stiffness_under(problem, newton, force)[0], 0.9 * expected, 1.1 * expected, rtol=1e-3
    )
    assert critical == pytest.approx(expected, rel=0.02)
    _, mode = stiffness_under(problem, newton, critical)
    points = problem.space.tabulate_dof_coordinates()
    line = np.isclose(points[:, 2], 0) & (points[:, 1] < 1e-9)
    x, deflection = everywhere(points[line, 0]), everywhere(mode[line, 2])
    _, first = np.unique(x.round(9), return_index=True)
    crossings = np.count_nonzero(np.diff(np.sign(deflection[first])) != 0)
    assert 2 * LENGTH / crossings == pytest.approx(2 * np.pi * (rigidity / FOUNDATION) ** 0.25, rel=0.06)
