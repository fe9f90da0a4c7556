"""Horizontal forces and their balance; the work of friction against mu N d."""

import numpy as np
import pytest
from assembled import build

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mechanics.time_step import TimeStep
from ncf_fenicsx.output.friction_work import FrictionWork

ELASTIC = {"rate": {"kind": "none"}, "shear": {"modulus": "1 GPa"}}
FRICTION = {"coefficient": 0.3, "stiffness": "1e9 Pa/m"}
LAYERS = {"kind": "one_sided", "friction": {"coefficient": 0.2}}
HELD = {"x_min": "fixed", "x_max": "free", "y_min": "symmetry", "y_max": "symmetry"}
PRESS = {"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "0.1 mm/s"}


def along(x, y=0.0):
    return {"travel": [f"{x} mm", f"{y} mm", "0 mm"], "speed": "1 mm/s"}


def rows(folder, tool, *path, sides=HELD, layers=1, **keys):
    stack = {"layers": layers, "size": ["12 mm", "6 mm"], "divisions": [12, 2], "grading": [0, 0], "sides": sides}
    table = {
        "laws": ELASTIC,
        "stack": stack,
        "tool": {"kind": "plate", "path": list(path)} | tool,
        "solver": {"force_tolerance": 1e-9},
        "output": {"picture": False},
    }
    result = run(Scene.from_table(table | keys), folder / tool.get("kind", "plate"))
    assert result.done, result.reason
    return result.history


def of(history, name):
    return np.array([row[name] for row in history])


def check_balance(history, axis):
    names = [name for name in history[0] if name.startswith(("tool_force", "mould_force")) and f"force_{axis}" in name]
    parts = [of(history, name) for name in names] + [-of(history, f"support_force_{axis}")]
    largest = np.abs(parts).max()
    assert largest > 0
    missing = np.abs(np.sum(parts, axis=0))
    assert missing.max() < 1e-6 * largest
    assert np.all(missing <= 1e-6 * np.abs(of(history, "support_force")))


def test_a_plate_that_slides_over_a_sheet_dissipates_mu_n_d(folder):
    """In steady sliding friction takes all that the tool gives; images take up the horizontal forces of the whole."""
    history = rows(folder, {"friction": FRICTION}, PRESS, along(1), sides={})
    assert not any(name.endswith(("force_x", "force_y")) for name in history[0])
    sliding = [row for row in history if row["time"] >= 2.3]
    assert len(sliding) > 2
    force, work, given = (of(sliding, name) for name in ("tool_force", "friction_work", "tool_work"))
    travelled = 1e-3 * (of(sliding, "time") - sliding[0]["time"])
    assert np.ptp(force) < 1e-4 * force[0]
    assert work[1:] - work[0] == pytest.approx(0.3 * force[0] * travelled[1:], rel=1e-4)
    assert given[1:] - given[0] == pytest.approx(work[1:] - work[0], rel=1e-3)
    # all but what the stick keeps, mu p over its stiffness
    spring = 0.3 * force[0] / (4 * 72e-6) / 1e9
    assert work[-1] == pytest.approx(0.3 * force[-1] * (1e-3 - spring), rel=1e-3)


SHIFT, DEPTH, PENALTY, STICK = 0.4e-3, 1e-6, 1e9, 1e8


def slid(problem, contact, nodes):
    """Work of friction in J and force in N, of the whole, after some nodes were moved over a contact in four steps."""
    friction, work = FrictionWork(problem), 0.0
    steps = TimeStep(problem, lambda *_: None, friction.state)
    for number in range(5):
        values = problem.displacement.x.array.reshape(-1, 3)
        values[nodes] = (SHIFT * number / 4 * 0.6, SHIFT * number / 4 * 0.8, -DEPTH)
        problem.contacts.move_tools(0.0, 1.0)
        problem.contacts.refresh()
        before, work = work, friction.observe()["friction_work"]
        assert work > before or number == 0
        steps.commit()
    assert contact.traction.x.array.any()
    return work


def test_layers_and_moulds_dissipate_mu_n_d_too():
    """Imposed shifts at constant pressure: mu p A times the shift, less what the stick keeps."""
    friction = {"coefficient": 0.3, "stiffness": f"{STICK} Pa/m"}
    stack = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]}
    touch = {"penalty": f"{PENALTY} Pa/m", "friction": friction}
    expected = 4 * 72e-6 * 0.3 * PENALTY * DEPTH * (SHIFT - 0.3 * PENALTY * DEPTH / STICK)
    layers, _ = build({"stack": stack, "interface": touch, "duration": "1 s"})
    interface = layers.contacts.layers[0]
    upper = np.isin(layers.contacts.body.spaces.numbers, interface.pairing.masters)
    upper |= layers.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3
    assert slid(layers, interface, upper) == pytest.approx(expected, rel=0.05)  # the upper face leaves the lower one
    over, _ = build({"stack": stack | {"layers": 1}, "mould": {"kind": "plate"} | touch, "duration": "1 s"})
    assert slid(over, over.contacts.mould, slice(None)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_horizontal_forces_balance(folder, axis):
    """Plies between a travelling foot and a mould, one side held: tools, mould and held side, in every step."""
    sides = {"x_min": "symmetry", "y_min": "symmetry", f"{axis}_min": "fixed"}
    tool = {"kind": "presser_foot", "size": ["4 mm", "4 mm"], "edge": "1 mm", "position": ["6 mm", "3 mm"]}
    mould = {"kind": "plate", "friction": {"coefficient": 0.2}}
    path = [PRESS | {"travel": ["0 mm", "0 mm", "-0.1 mm"]}, along(*(0.1, 0) if axis == "x" else (0, 0.1))]
    history = rows(
        folder, tool | {"friction": {"coefficient": 0.3}}, *path, sides=sides, layers=2, mould=mould, interface=LAYERS
    )
    check_balance(history, axis)
    other = {"x": "y", "y": "x"}[axis]
    assert not any(f"force_{other}" in name for name in history[0])


def test_a_roller_without_friction_is_pushed_back_by_what_it_bears_against(folder):
    """Beside a held side the face leans: its pressure has a horizontal part, which the side carries."""
    tool = {"kind": "cylinder", "radius": "5 mm", "width": "infinite", "position": ["3 mm", "0 mm"]}
    history = rows(folder, tool, PRESS)
    check_balance(history, "x")
    assert "mould_force_x" not in history[0]
    assert "friction_work" not in history[0]
    flat = rows(folder, {"kind": "plate"}, PRESS)
    assert "tool_force_x" not in flat[0]
