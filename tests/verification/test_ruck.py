"""A ruck that a foot pushes up in a heavy sheet on a smooth plane, against the heavy elastica.

B th'' = -P sin th - q (s - L/2) cos th with th = th' = 0 at the lift-off and th = 0 at the crest (Vella et al. 2009).
In units of l = (B / q)^(1/3).
"""

import numpy as np
import pytest
from layers import everywhere, simulate
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

pytestmark = pytest.mark.two_ranks

THICKNESS, MODULUS, POISSON, GRAVITY = 0.5e-3, 1e6, 0.2, 30.0
RUCK = {
    "gravity": f"{GRAVITY} m/s^2",
    "stack": {
        "layers": 1,
        "thickness": f"{THICKNESS} m",
        "areal_density": "356.25 g/m^2",
        "size": ["80 mm", "0.5 mm"],
        "divisions": [160, 1],
        "grading": [0, 0],
        "sides": {"x_min": "free", "x_max": "fixed", "y_min": "symmetry", "y_max": "symmetry"},
    },
    "laws": {
        "bending": {"modulus": f"{MODULUS} Pa", "poisson": POISSON},
        "shear": {"modulus": "1 MPa"},
        "compaction": {"kind": "power", "scale": "5 MPa", "exponent": 1.0},  # stiff: the elastica has no thickness
    },
    "solver": {"viscous_share": 1e9},  # it snaps up, and only where it ends at rest is looked at
    "mould": {"kind": "plate"},
    "tool": {
        "kind": "presser_foot",
        "size": ["10 mm", "10 mm"],
        "edge": "1 mm",
        "position": ["15 mm", "0 mm"],
        "friction": {"coefficient": 2.0},
    },
    "output": {"picture": False, "report": False, "fields_every": 1000},
}
RIGIDITY = MODULUS * THICKNESS**3 / 12 / (1 - POISSON**2)
UNIT = (RIGIDITY / (0.35625 * GRAVITY)) ** (1 / 3)
"""Length l in m."""
EDGE = 22e-3
"""X in m from which the sheet is free of the foot."""


def shape(length, force):
    """Angle at the crest, place and height of the crest of a sheet of a length under a force, from its lift-off."""

    def slopes(s, state):
        angle, bend = state[:2]
        return [bend, -force * np.sin(angle) - (s - length / 2) * np.cos(angle), np.cos(angle), np.sin(angle)]

    end = solve_ivp(slopes, (0, length / 2), [0, 0, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]
    return end[0], end[2], end[3]


def elastica(length):
    """Excess length, height and force of a ruck."""
    small = 80.76 / length**2
    forces = np.linspace(1.05 * small, 0.7 * small, 30)
    angles = [shape(length, force)[0] for force in forces]
    first = next(n for n in range(29) if angles[n] * angles[n + 1] < 0)
    force = brentq(lambda force: shape(length, force)[0], forces[first + 1], forces[first])
    _, reach, height = shape(length, force)
    return length - 2 * reach, height, force


@pytest.mark.parametrize(
    ("length", "expected"), [(3.0, (0.034610, 0.193289, 8.98119)), (4.0, (0.248934, 0.587897, 5.06973))]
)
def test_the_elastica_is_that_of_the_literature(length, expected):
    assert elastica(length) == pytest.approx(expected, rel=1e-4)


def pushed(folder, travel, order, divisions):
    """Height, length in plan and force of a ruck over those of the elastica of its excess length; its slope in rad."""
    table = RUCK | {"stack": RUCK["stack"] | {"order": order, "divisions": [divisions, 1]}}
    # Pressed deeper, the foot's edge lifts the sheet, and a steep ruck rests there, not on the plane. A steep ruck
    # wanders on the smooth plane before it rests.
    down, along = ["0 mm", "0 mm", "-0.003 mm"], [f"{travel} mm", "0 mm", "0 mm"]
    path = [
        {"travel": down, "speed": "1 mm/min"},
        {"travel": along, "speed": "2 mm/min"},
        {"hold": "60 s" if travel > 1 else "20 s"},
    ]
    simulation, history = simulate(table | {"tool": RUCK["tool"] | {"path": path}}, folder)
    last = history[-1]
    excess, height = measured(simulation.problem)
    length = brentq(lambda length: elastica(length)[0] - excess / UNIT, 2.0, 4.5)
    more, expected, force = elastica(length)
    carried = abs(last["support_force_x"]) / width(simulation.scene)
    assert last["viscous_force"] < 1e-3 * abs(last["support_force_x"])
    ratios = (
        height / UNIT / expected,
        last["wrinkle_length_1"] / UNIT / (length - more),
        carried * UNIT**2 / RIGIDITY / force,
    )
    return *ratios, last["misalignment_max_1"]


@pytest.mark.slow
@pytest.mark.parametrize(("order", "divisions"), [(1, 160), (2, 80)])
@pytest.mark.parametrize(("travel", "slope"), [(0.3, 12), (0.6, 16), (2.6, 30)])
def test_a_ruck_is_the_heavy_elastica(folder, travel, slope, order, divisions):
    height, length, force, steepest = pushed(folder, travel, order, divisions)
    assert height == pytest.approx(1, rel=0.01)
    assert length == pytest.approx(1, rel=0.02)
    assert force == pytest.approx(1, rel=0.02)
    assert np.degrees(steepest) > slope


def width(scene):
    """Width in m that the history's forces belong to: that of the modelled strip and its images."""
    return scene.stack.size[1] * scene.stack.sides.copies


def measured(problem):
    """Excess length and height of the mid-plane beyond the foot in m."""
    points, moved = (
        everywhere(values)
        for values in (problem.space.tabulate_dof_coordinates(), problem.displacement.x.array.reshape(-1, 3))
    )
    free = (points[:, 1] < 1e-9) & (points[:, 0] > EDGE)
    faces = []
    for height in (0.0, THICKNESS):
        at = free & np.isclose(points[:, 2], height, atol=1e-9)
        _, first = np.unique(points[at, 0].round(9), return_index=True)
        faces.append((points + moved)[at][first])
    middle = (faces[0] + faces[1]) / 2
    pieces = np.diff(middle, axis=0)
    excess = (np.linalg.norm(pieces, axis=1) - pieces[:, 0]).sum()
    return excess, middle[:, 2].max() - middle[-1, 2]
