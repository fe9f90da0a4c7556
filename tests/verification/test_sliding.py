"""Friction over distances: a block that is dragged over a mould, and a belt around a cylinder (Euler and Eytelwein)."""

import numpy as np
import pytest
from assembled import COMM
from layers import simulate

pytestmark = pytest.mark.two_ranks

PRESS = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "0.1 mm/s"}
ELASTIC = {"rate": {"kind": "none"}}
ENFORCEMENTS = {
    "penalty": {},
    "augmented Lagrangian": {"contact": {"kind": "augmented_lagrangian"}},
    "Nitsche": {"contact": {"kind": "nitsche"}},
}


@pytest.mark.parametrize("way", ENFORCEMENTS)
def test_a_block_is_dragged_over_a_mould_by_its_coefficient(folder, way):
    table = {
        "stack": {
            "layers": 1,
            "size": ["12 mm", "6 mm"],
            "divisions": [6, 2],
            "grading": [0, 0],
            "sides": dict.fromkeys(("x_min", "x_max", "y_min", "y_max"), "free"),
        },
        "laws": ELASTIC | {"shear": {"modulus": "1 GPa"}},
        "mould": {"kind": "plate", "friction": {"coefficient": 0.3}} | ENFORCEMENTS[way],
        "tool": {
            "kind": "plate",
            "friction": {"coefficient": 1.0},
            "path": [PRESS, {"travel": ["5 mm", "2 mm", "0 mm"], "speed": "1 mm/s"}],
        }
        | ENFORCEMENTS[way],
    }
    _, history = simulate(table, folder)
    last = history[-1]
    pushed = np.array([last["mould_force_x"], last["mould_force_y"]])
    assert pushed == pytest.approx(0.3 * last["support_force"] * np.array([5, 2]) / np.hypot(5, 2), rel=0.01)
    assert [last["tool_force_x"], last["tool_force_y"]] == pytest.approx(-pushed, rel=1e-6)
    assert last["friction_work"] > 0.9 * 0.3 * last["support_force"] * np.hypot(5, 2) * 1e-3


COEFFICIENT = 0.3
BELT = {
    "gravity": "0 m/s^2",
    "stack": {
        "layers": 1,
        "thickness": "0.5 mm",
        "areal_density": "356.25 g/m^2",
        "size": ["80 mm", "0.5 mm"],
        "divisions": [160, 1],
        "grading": [0, 0],
        "sides": {"x_min": "fixed", "x_max": "fixed", "y_min": "symmetry", "y_max": "symmetry", "bottom": "free"},
    },
    "laws": ELASTIC
    | {
        "in_plane": {"modulus": "10 MPa", "poisson": 0.0},
        "bending": {"modulus": "0.1 MPa"},
        "shear": {"modulus": "1 MPa"},
    },
    "tool": {
        "kind": "cylinder",
        "width": "infinite",
        "radius": "15 mm",
        "position": ["40 mm", "0 mm"],
        "friction": {"coefficient": COEFFICIENT},
        "path": [
            {"travel": ["0 mm", "0 mm", "-20 mm"], "speed": "1 mm/s"},
            {"travel": ["3 mm", "0 mm", "0 mm"], "speed": "0.3 mm/s"},
        ],
    },
}


@pytest.mark.serial
def test_a_belt_around_a_cylinder_pulls_as_euler_and_eytelwein_say(folder):
    simulation, _ = simulate(BELT, folder)
    problem = simulation.problem
    reactions = simulation.newton.evaluate_residual().reshape(-1, 3)
    x = problem.space.tabulate_dof_coordinates()[: len(reactions), 0]
    ends = [COMM.allreduce(reactions[np.abs(x - place) < 1e-9].sum(axis=0)) for place in (0.0, 80e-3)]
    angles = [np.arctan2(abs(end[2]), abs(end[0])) for end in ends]
    pulls = [np.linalg.norm(end) for end in ends]
    assert min(angles) > 0.4
    assert max(pulls) / min(pulls) == pytest.approx(np.exp(COEFFICIENT * sum(angles)), rel=0.01)
