"""Orders of convergence in the time step, and ways of Newton's method that lead to one solution."""

import numpy as np
import pytest
from assembled import build, step_of

from ncf_fenicsx import Scene, SceneError, run

pytestmark = pytest.mark.serial

RELAXATION = {
    "stack": {"layers": 2, "size": ["6 mm", "4 mm"], "divisions": [2, 1], "grading": [0, 0]},
    "laws": {"relaxation": {"kind": "maxwell", "branches": [{"share": 0.3, "time": "5 s"}]}},
    "tool": {
        "kind": "plate",
        "path": [{"travel": ["0 mm", "0 mm", "-0.5 mm"], "speed": "1 mm/min"}, {"hold": "10 s"}],
    },
}
ROLLER = {
    "stack": {"layers": 2, "size": ["12 mm", "4 mm"], "divisions": [12, 1], "grading": [0, 0]},
    "laws": {"shear": {"modulus": "1 MPa"}},
    "tool": {"width": "infinite", "path": [{"travel": ["0 mm", "0 mm", "-0.4 mm"], "speed": "1 mm/min"}]},
}
QUIET = {"output": {"picture": False, "report": False, "fields_every": 1000}}
WEIGHTLESS = {"gravity": "0 m/s^2"}  # the tool touches from the start: no step is shortened to its first touch


def forces(table, pressed, steps, folder):
    """Force in N at the end of the travel down, with a number of steps to it, and at the end."""
    size = f"{pressed / steps!r} s"
    solver = {
        "first_step": size,
        "largest_step": size,
        "target_iterations": 30,
        "max_iterations": 40,
        "time_tolerance": 1.0,
    }
    solver |= {"force_tolerance": 1e-10, "time_tolerance": 1.0}
    result = run(Scene.from_table(table | QUIET | WEIGHTLESS | {"solver": solver}), folder)
    assert result.done, result.reason
    assert not any(row["step_cuts"] for row in result.history)
    at_end = next(row for row in result.history if row["time"] == pytest.approx(pressed))
    return at_end["tool_force"], result.history[-1]["tool_force"]


@pytest.mark.parametrize(("table", "pressed", "low", "high"), [(RELAXATION, 30.0, 1.9, 2.4), (ROLLER, 24.0, 0.9, 1.1)])
def test_the_force_converges_with_the_time_step(folder, table, pressed, low, high):
    """Maxwell branches are integrated to second order; the closing speed of each place to first."""
    found = np.array([forces(table, pressed, steps, folder / str(steps)) for steps in (8, 16, 32, 64)])
    changes = np.abs(np.diff(found, axis=0))
    orders = np.log2(changes[:-1] / changes[1:])
    assert (orders > low).all(), orders
    assert (orders < high).all(), orders
    assert changes[0] / found[-1] == pytest.approx(np.zeros(2), abs=2e-3)


def history(table, folder, **solver):
    result = run(Scene.from_table(table | QUIET | WEIGHTLESS | {"solver": solver}), folder)
    assert result.done, result.reason
    return result.history


@pytest.mark.parametrize(("table", "pressed"), [(RELAXATION, 30.0), (ROLLER, 24.0)], ids=["relaxation", "local speed"])
def test_steps_ten_times_longer_or_shorter_keep_the_history_within_the_tolerance(folder, table, pressed):
    exact = history(table, folder / "exact", first_step=f"{pressed / 400} s", largest_step=f"{pressed / 400} s")
    largest = max(row["tool_force"] for row in exact)
    for factor in (0.1, 1, 10):
        sizes = {"first_step": f"{factor * pressed / 30} s", "largest_step": f"{factor * pressed / 8} s"}
        rows = history(table, folder / str(factor), **sizes)
        times = [row["time"] for row in exact]
        expected = np.interp([row["time"] for row in rows], times, [row["tool_force"] for row in exact])
        worst = np.abs(expected - [row["tool_force"] for row in rows]).max()
        assert worst < 0.005 * largest, factor
    loose = history(table, folder / "loose", **sizes, time_tolerance=1.0)
    assert len(loose) < len(rows)


def test_a_long_hold_changes_nothing_before_it(folder):
    tool = RELAXATION["tool"]
    short, long = (
        history(RELAXATION | {"tool": tool | {"path": [tool["path"][0], {"hold": hold}]}}, folder / hold)
        for hold in ("10 s", "3 day")
    )
    pressed = [row for row in short if row["time"] <= 30.0]
    assert [row["tool_force"] for row in long[: len(pressed)]] == [row["tool_force"] for row in pressed]


@pytest.mark.parametrize(
    ("laws", "controlled"),
    [({}, True), ({"rate": {"feed": "process"}}, False), ({"rate": {"kind": "none"}, "unloading": {}}, False)],
    ids=["local speed", "speed of the process", "unloading"],
)
def test_where_no_law_follows_time_no_error_in_time_is_built(table, laws, controlled):
    problem, newton = build(table | {"laws": laws})
    step = step_of(problem, newton)
    assert (step.time_error is not None) == controlled
    assert any(field.name.startswith("time_error") for field in step.state) == controlled


def test_a_step_that_is_too_long_in_time_leaves_no_trace(table):
    problem, newton = build(table | {"laws": {"relaxation": {}}, "solver": {"time_tolerance": 1e-9}})
    step = step_of(problem, newton)
    assert step.attempt(0.0, 0.0).converged
    step.commit()
    before = [field.values.copy() for field in step.state]
    outcome = step.attempt(0.0, 4.0)
    assert not outcome.converged
    assert "local error in time" in outcome.reason
    assert all(np.array_equal(old, field.values) for old, field in zip(before, step.state, strict=True))


@pytest.mark.parametrize("search", ["critical_point", "error_oriented", "residual", "trust_region"])
def test_every_line_search_leads_to_the_same_solution(folder, search):
    expected = run(Scene.from_table(ROLLER | QUIET), folder / "full").history[-1]
    result = run(Scene.from_table(ROLLER | QUIET | {"solver": {"line_search": search}}), folder / search)
    assert result.done, result.reason
    for name in ("tool_force", "vf_max"):  # within what other time steps make
        assert result.history[-1][name] == pytest.approx(expected[name], rel=2e-3)


def test_a_line_search_does_not_go_with_a_tool_under_a_force():
    tool = {"width": "infinite", "path": [{"hold": "1 s", "force": "1 N"}]}
    with pytest.raises(SceneError, match=r"solver\.line_search = 'residual': expected .full"):
        Scene.from_table({"tool": tool, "solver": {"line_search": "residual"}})
