"""Steps that end where a tool first touches, and that no tool travels too far in."""

from itertools import pairwise

import pytest
from assembled import COMM

from ncf_fenicsx import Scene, run

pytestmark = pytest.mark.two_ranks

STACK = {"layers": 1, "size": ["6 mm", "4 mm"], "divisions": [4, 2], "grading": [0, 0]}
SPEED = 1e-3 / 60


def pressed(folder, travel="-0.3 mm", solver=None, **tool):
    """History of a layer under a tool."""
    path = [{"travel": ["0 mm", "0 mm", travel], "speed": "1 mm/min"}]
    table = {
        "stack": STACK,
        "gravity": "0 m/s^2",
        "tool": {"kind": "plate", "path": path} | tool,
        "solver": {"time_tolerance": 1.0} | (solver or {}),  # what is looked at are other limits
        "output": {"picture": False, "report": False},
    }
    result = run(Scene.from_table(table), folder)
    assert result.done
    return result.history


@pytest.mark.parametrize(
    "tool", [{"kind": "plate"}, {"kind": "cylinder", "width": "infinite"}], ids=lambda tool: tool["kind"]
)
def test_a_step_ends_where_a_tool_first_touches(folder, tool):
    history = pressed(folder, clearance="0.1 mm", **tool)
    touch = next(k for k, row in enumerate(history) if row["tool_displacement"] > 0.999e-4)
    assert history[touch]["tool_displacement"] == pytest.approx(1e-4, abs=1e-8)
    assert history[touch]["tool_force"] == 0
    assert history[touch]["time"] == pytest.approx(1e-4 / SPEED, rel=1e-4)
    assert all(row["tool_force"] > 0 for row in history[touch + 1 :])
    assert history[touch + 1]["time_step"] >= history[1]["time_step"]


def test_a_tool_that_touches_from_the_start_takes_the_steps_it_is_told(folder):
    history = pressed(folder, solver={"first_step": "3 s", "largest_step": "3 s"})
    assert [row["time_step"] for row in history[1:]] == pytest.approx([3] * 6)


def test_no_tool_travels_farther_in_a_step_than_it_may(folder):
    solver = {"first_step": "9 s", "largest_step": "18 s", "step_travel": 0.02}
    history = pressed(folder, solver=solver)
    down = [row["tool_displacement"] for row in history]
    steps = [after - before for before, after in pairwise(down)]
    assert max(steps) == pytest.approx(0.02 * 2e-3, rel=1e-6)
    free = pressed(folder / "free", solver=solver | {"step_travel": 10})
    assert len(free) < len(history)
    assert COMM.size > 1 or free[-1]["tool_force"] == pytest.approx(history[-1]["tool_force"], rel=0.05)
