"""Coulomb friction: sticks below mu p, slides at mu p, between layers too; a rolling tool hardly drags."""

import numpy as np
import pytest
from assembled import COMM, assign, build, step_of

from ncf_fenicsx import Scene
from ncf_fenicsx.simulation import Simulation

pytestmark = pytest.mark.two_ranks

QUIET = {"picture": False, "report": False}
ELASTIC = {"rate": {"kind": "none"}}
AREA = 12e-3 * 6e-3
STICK, MU = 1e6, 0.3


class Watched(Simulation):
    """A run that keeps the force on its first tool in every accepted step, of the modelled part.

    Tractions and pressures at this rank's nodes between layers are kept too, those of the last step.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.forces = []
        self.frictional = [layer for layer in self.problem.contacts.layers if layer.settings.friction is not None]
        self.forms = [
            [layer.face.density(layer._tangential), layer.face.density(layer.pressure)] for layer in self.frictional
        ]

    def accept(self, *arguments):
        pairs = zip(self.frictional, self.forms, strict=True)
        self.between = [[layer.face.values(form) for form in forms] for layer, forms in pairs]
        self.forces.append(self.problem.contacts.tools[0].force())  # before multipliers take their next value
        super().accept(*arguments)


def watch(table, folder):
    """Times in s and forces in N on the tool, after a whole run."""
    simulation = Watched(Scene.from_table(table | {"output": QUIET}), folder, COMM, False)
    result = simulation.run()
    assert result.done, result.reason
    return np.array([row["time"] for row in result.history]), np.array(simulation.forces), simulation


def block(tool, *path, friction=None, **keys):
    """One layer, stiff in its plane and held at x = 0, so that its top moves along only as the tool's stick gives."""
    table = {
        "laws": ELASTIC | {"shear": {"modulus": "1 GPa"}},
        "stack": {"layers": 1, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": tool | {"path": list(path)} | ({} if friction is None else {"friction": friction}),
        "solver": {"first_step": "1 s", "largest_step": "1 s", "force_tolerance": 1e-9},
    }
    return table | keys


FRICTION = {"coefficient": MU, "stiffness": f"{STICK} Pa/m"}
PRESS = {"travel": ["0 mm", "0 mm", "-0.4 mm"], "speed": "0.1 mm/s"}


def along(x, y=0.0, speed="1 mm/s", **keys):
    return {"travel": [f"{x} mm", f"{y} mm", "0 mm"], "speed": speed} | keys


def test_a_plate_sticks_then_slides_and_back(folder):
    """Force over travel: a line of the stick stiffness, mu Fz, the same line back from there, minus mu Fz."""
    table = block({"kind": "plate"}, PRESS, along(4, speed="0.2 mm/s"), along(-6, speed="0.2 mm/s"), friction=FRICTION)
    times, forces, _ = watch(table, folder)
    pressed = forces[times <= 4.0]
    assert np.abs(pressed[:, :2]).max() < 1e-9 * pressed[-1, 2]
    limit = MU * forces[-1, 2]
    assert forces[times >= 4.0][:, 2] == pytest.approx(forces[-1, 2], rel=1e-4)
    moved = np.where(times <= 24, 0.2e-3 * (times - 4), 4e-3 - 0.2e-3 * (times - 24))
    drag = -forces[:, 0]  # the fabric holds the tool back
    yielding = limit / (STICK * AREA)
    assert 0.4e-3 < yielding < 2e-3
    sticks = (times > 4) & (moved < 0.95 * yielding) & (times <= 24)
    slides = (times > 4) & (moved > 1.05 * yielding) & (times <= 24)
    back = (times > 24) & (4e-3 - moved < 1.9 * yielding)
    slides_back = (times > 24) & (4e-3 - moved > 2.1 * yielding)
    assert min(np.count_nonzero(part) for part in (sticks, slides, back, slides_back)) >= 2
    assert drag[sticks] == pytest.approx(STICK * AREA * moved[sticks], rel=1e-2)
    assert drag[slides] == pytest.approx(MU * forces[slides, 2], rel=1e-6)
    assert drag[back] == pytest.approx(limit - STICK * AREA * (4e-3 - moved[back]), rel=1e-2, abs=1e-2 * limit)
    assert drag[slides_back] == pytest.approx(-MU * forces[slides_back, 2], rel=1e-6)
    assert np.abs(forces[:, 1]).max() < 1e-6 * limit


@pytest.mark.parametrize("contact", ["penalty", "nitsche", "augmented_lagrangian"])
def test_friction_acts_against_the_motion_in_the_plane(folder, contact):
    """A travel at an angle: the force is mu Fz against it, however contact is enforced."""
    tool = {"kind": "plate", "contact": {"kind": contact}}
    table = block(tool, PRESS, along(1.8, 2.4), friction=FRICTION)
    _, forces, _ = watch(table, folder)
    assert np.hypot(*forces[-1, :2]) == pytest.approx(MU * forces[-1, 2], rel=1e-6)
    assert forces[-1, :2] == pytest.approx(-MU * forces[-1, 2] * np.array([0.6, 0.8]), rel=1e-2)


def test_without_friction_a_travelling_plate_drags_nothing(folder):
    _, forces, _ = watch(block({"kind": "plate"}, PRESS, along(3)), folder)
    assert forces[-1, 2] > 0.01
    assert np.abs(forces[:, :2]).max() < 1e-12 * forces[-1, 2]


def test_a_sideways_force_vanishes_with_the_contact(folder):
    """A plate that slides, then lifts off, keeps no traction."""
    lift = {"travel": ["0 mm", "0 mm", "1 mm"], "speed": "0.5 mm/s"}
    _, forces, simulation = watch(block({"kind": "plate"}, PRESS, along(3), lift, along(-3), friction=FRICTION), folder)
    assert not forces[-1].any()
    assert not simulation.problem.contacts.tools[0].traction.x.array.any()


def rolled(folder, roll, mu=0.5):
    tool = {"width": "infinite", "radius": "5 mm", "position": ["4 mm", "0 mm"]}
    friction = None if mu is None else {"coefficient": mu, "stiffness": "1e7 Pa/m"}
    press = {"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "0.1 mm/s"}
    table = block(tool, press, along(3, speed="0.5 mm/s", roll=roll), friction=friction)
    table["stack"] |= {"divisions": [24, 1]}
    table["laws"] = ELASTIC
    table["solver"] = {"first_step": "1 s", "largest_step": "1 s", "force_tolerance": 1e-8}
    return watch(table, folder)[1]


def test_a_rolling_tool_hardly_drags(folder):
    slid, turned, free = (
        rolled(folder / name, *way)
        for name, way in {"slides": (False,), "rolls": (True,), "free": (False, None)}.items()
    )
    assert slid[-1, 2] > 0.01
    # what the surface's slope adds is there without friction, too
    drag = slid[-1, 0] - free[-1, 0]
    assert drag == pytest.approx(-0.5 * slid[-1, 2], rel=0.1)
    assert abs(turned[-1, 0] - free[-1, 0]) < 0.05 * abs(drag)


def two_layers(divisions, **keys):
    stack = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": divisions, "grading": [0, 0]}
    interface = {"penalty": "1e9 Pa/m", "friction": {"coefficient": MU, "stiffness": "1e8 Pa/m"}}
    return {"stack": stack, "interface": interface, "duration": "1 s"} | keys


PLACES = {
    "penalty": ([1, 2, 4, 8, 7, 3, -3], [100, 200, 300, 300, 200, -200, -300]),
    "augmented_lagrangian": ([10, 20, 40, 80, 70, 30, -30], [300, 600, 900, 1200, 200, -1800, -2100]),
}
"""Shifts in um one after the other, and the tractions in Pa after each: by 1e8 Pa/m up to 0.3 of 1 kPa, or of n kPa."""


@pytest.mark.parametrize("contact", PLACES)
@pytest.mark.parametrize("divisions", [[6, 2], [[6, 2], [5, 3]]], ids=["matching", "different"])
def test_layers_stick_then_slide_on_each_other(divisions, contact):
    """The upper layer is held down by 1 um, 1 kPa more with each update of multipliers, and shifted step by step."""
    table = two_layers(divisions)
    table["interface"]["contact"] = {"kind": contact}
    problem, _ = build(table)
    layer = problem.contacts.layers[0]
    upper = np.isin(problem.contacts.body.spaces.numbers, layer.pairing.masters)
    upper |= problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3
    direction, overlap = np.array([0.6, 0.8]), AREA
    for number, (place, traction) in enumerate(zip(*PLACES[contact], strict=True)):
        shift = place * 1e-6 * direction
        problem.displacement.x.array.reshape(-1, 3)[upper] = (*shift, -1e-6)
        problem.contacts.refresh()
        force = -COMM.allreduce(layer.residual()[1].sum(axis=0))
        pressure = 1e3 if contact == "penalty" else 1e3 * (number + 1)
        assert force[2] == pytest.approx(pressure * overlap, rel=1e-6)
        assert force[:2] == pytest.approx(-traction * overlap * direction, rel=1e-6)
        step_of(problem).commit()
        if divisions != [6, 2]:  # nodes that match stay together as far as a twentieth of an element
            overlap = (12e-3 - abs(shift[0])) * (6e-3 - abs(shift[1]))


def test_a_frictionless_interface_carries_no_shear():
    table = two_layers([[6, 2], [5, 3]], interface={"penalty": "1e9 Pa/m"})
    problem, _ = build(table)
    layer = problem.contacts.layers[0]
    upper = np.isin(problem.contacts.body.spaces.numbers, layer.pairing.masters)
    for shift in (0.0, 1e-3):
        problem.displacement.x.array.reshape(-1, 3)[upper] = (shift, 0.5 * shift, -1e-6)
        problem.contacts.refresh()
        force = COMM.allreduce(layer.residual()[1].sum(axis=0))
        assert abs(force[2]) > 1e-2
        assert np.abs(force[:2]).max() < 1e-12 * abs(force[2])
        step_of(problem).commit()


FIBRES = {"kind": "fibre_families", "plies": [[0], [90]], "modulus": "1 GPa", "modulus_compression": "1 GPa"}


@pytest.mark.parametrize("stiffness", [0.1, 1.0], ids=["soft stick", "default stick"])
def test_a_layer_slides_over_one_that_is_held(folder, stiffness):
    """A foot stretches the upper layer, soft along x; the lower one has fibres along x and holds it back with mu p."""
    table = {
        "gravity": "0 m/s^2",
        "laws": ELASTIC | {"in_plane": FIBRES | {"shear_modulus": "40 kPa"}},
        "stack": {
            "layers": 2,
            "size": ["12 mm", "3 mm"],
            "divisions": [12, 1],
            "grading": [0, 0],
            "sides": {"y_max": "symmetry"},
        },
        "interface": {"penalty": 30.0, "friction": {"coefficient": 0.2, "stiffness": stiffness}},
        "tool": {
            "kind": "plate",
            "penalty": 30.0,
            "friction": {"coefficient": 0.6},
            "path": [
                {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "0.1 mm/s"},
                along(1.0, speed="0.1 mm/s"),
                along(-2.0, speed="0.1 mm/s"),
            ],
        },
        "solver": {"first_step": "1 s", "largest_step": "1 s", "force_tolerance": 1e-9},
    }
    for number, sign in ((2, 1), (3, -1)):
        part = table | {"tool": table["tool"] | {"path": table["tool"]["path"][:number]}}
        _, forces, simulation = watch(part, folder / str(number))
        layer = simulation.problem.contacts.layers[0]
        traction, pressure = simulation.between[0]
        positions = simulation.problem.space.tabulate_dof_coordinates()
        nodes = layer.face.owned()
        far = nodes[abs(positions[nodes, 0] - 8.5e-3) < 3e-3]  # not the edge, which hangs over
        assert COMM.allreduce(len(far)) == 6 * 2
        assert pressure[far].min(initial=1e9) > 500
        sizes = np.linalg.norm(traction[far], axis=1)
        assert sizes == pytest.approx(0.2 * pressure[far], rel=1e-6)
        assert np.all(sign * traction[far, 0] > 0.19 * pressure[far])
        held = nodes[positions[nodes, 0] < 1e-6]
        assert np.all(np.linalg.norm(traction[held], axis=1) < 0.2 * pressure[held])
        assert sign * forces[-1, 0] < -0.1 * forces[-1, 2]


def test_a_fabric_at_rest_under_friction_is_left_alone():
    """Pressing straight down drags nothing along, and no traction appears without a slip."""
    problem, _ = build(block({"kind": "plate"}, PRESS, friction=FRICTION))
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], 1e-6 * x[2] / 2e-3]))
    problem.start.x.array[:] = problem.displacement.x.array
    force = problem.contacts.tools[0].force()
    assert force[2] > 0
    assert not force[:2].any()
