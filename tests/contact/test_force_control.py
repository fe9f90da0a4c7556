"""Tools under a given force: the force is carried, the height follows, and nothing else changes."""

import re

import numpy as np
import pytest
from assembled import COMM, build, step_of

from ncf_fenicsx import Scene, SceneError, run

pytestmark = pytest.mark.two_ranks

QUIET = {"picture": False, "report": False}
TOOLS = {"plate": {"kind": "plate"}, "cylinder": {"width": "infinite"}}
AREA = 4 * 72e-6
"""Of the whole stack in m2."""


def scene(tool, *path, **keys):
    table = {
        "laws": {"rate": {"kind": "none"}},
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [12, 1], "grading": [0.0, 0.0]},
        "tool": tool | {"path": list(path)},
        "output": QUIET,
    }
    return Scene.from_table(table | keys)


def finished(scene, folder):
    result = run(scene, folder)
    assert result.done, result.reason
    return result.history


def column(history, name):
    return np.array([row[name] for row in history])


def down(height, speed="1 mm/min"):
    return {"travel": ["0 mm", "0 mm", f"{-height!r} m"], "speed": speed}


def check_ramp(history, start, end, at_start, at_end):
    """Force in every accepted step of a segment from a time (s) to another."""
    times = column(history, "time")
    inside = (times > start * (1 + 1e-9)) & (times <= end * (1 + 1e-9))
    assert np.count_nonzero(inside) >= 2
    expected = at_start + (at_end - at_start) * (times[inside] - start) / (end - start)
    assert column(history, "tool_force")[inside] == pytest.approx(expected, rel=1e-6)


def last_of_segment(history, end):
    return next(row for row in history if row["time"] >= end * (1 - 1e-9))


@pytest.mark.parametrize("clearance", ["0 mm", pytest.param("0.1 mm", marks=pytest.mark.serial)])
@pytest.mark.parametrize("name", TOOLS)
def test_a_force_is_reached_by_a_ramp_at_the_height_that_a_travel_needs_for_it(folder, name, clearance):
    """From the start, where the tool touches the stack or has to find it; then the same height without control."""
    force = {"plate": 2.0, "cylinder": 0.15}[name]
    tool = TOOLS[name] | {"clearance": clearance}
    history = finished(scene(tool, {"hold": "10 s", "force": f"{force} N"}), folder / "force")
    assert history[-1]["tool_force"] == pytest.approx(force, rel=1e-6)
    check_ramp(history, 0.0, 10.0, 0.0, force)
    height = history[-1]["tool_displacement"]
    assert 1e-4 < height < 1.5e-3
    assert np.all(np.diff(column(history, "tool_displacement")) > 0)
    given = finished(scene(tool, down(height)), folder / "height")
    assert given[-1]["tool_displacement"] == pytest.approx(height, rel=1e-12)
    assert given[-1]["tool_force"] == pytest.approx(force, rel=1e-5)
    if name == "plate":
        law, vf0 = scene(tool, down(1e-3)).laws.compaction, scene(tool, down(1e-3)).stack.initial_volume_fraction
        pressures = law.pressure(np.array([history[-1][f"vf_mean_layer_{layer}"] for layer in (1, 2)]), vf0)
        weight = history[-1]["weight"] / AREA
        assert pressures - force / AREA == pytest.approx([0.75 * weight, 0.25 * weight], rel=2e-2)


@pytest.mark.parametrize("name", TOOLS)
@pytest.mark.parametrize("more", [1.5, pytest.param(0.5, marks=pytest.mark.serial)])
def test_a_force_after_a_travel_starts_from_the_force_that_there_is_and_a_lift_ends_it(folder, name, more):
    press = {"plate": 0.4e-3, "cylinder": 0.2e-3}[name]
    alone = finished(scene(TOOLS[name], down(press)), folder / "travel")
    reached, seconds = alone[-1]["tool_force"], alone[-1]["time"]
    assert reached > 1e-2
    target = more * reached
    path = [down(press), {"hold": "8 s", "force": f"{target!r} N"}, down(-0.03e-3), down(-3e-3, "20 mm/min")]
    history = finished(scene(TOOLS[name], *path), folder / "then")
    start = last_of_segment(history, seconds)
    assert start["tool_force"] == pytest.approx(reached, rel=1e-5)  # other steps: normals between layers lag by one
    check_ramp(history, seconds, seconds + 8, start["tool_force"], target)
    held = last_of_segment(history, seconds + 8)
    assert np.sign(held["tool_displacement"] - press) == np.sign(more - 1)
    given = finished(scene(TOOLS[name], down(held["tool_displacement"])), folder / "height")
    assert given[-1]["tool_force"] == pytest.approx(target, rel=1e-5)
    lifted = last_of_segment(history, seconds + 9.8)
    assert lifted["tool_displacement"] == pytest.approx(held["tool_displacement"] - 0.03e-3, rel=1e-9)
    assert 0 < lifted["tool_force"] < target
    assert history[-1]["tool_displacement"] == pytest.approx(lifted["tool_displacement"] - 3e-3, rel=1e-9)
    assert history[-1]["tool_force"] == 0.0


def test_a_relaxing_stack_creeps_under_a_constant_force(folder):
    """Ever slower, until the pressure of slow loading alone carries the force, as if nothing had relaxed."""
    laws = {"rate": {"kind": "none"}, "relaxation": {"branches": [{"share": 0.5, "time": "3 s"}]}}
    path = [{"hold": "1 s", "force": "2 N"}, {"hold": "6 s", "force": "2 N"}, {"hold": "60 s", "force": "2 N"}]
    solver = {"largest_step": "3 s", "first_step": "0.2 s"}
    history = finished(scene(TOOLS["plate"], *path, laws=laws, solver=solver), folder / "creep")
    check_ramp(history, 1.0, 67.0, 2.0, 2.0)
    times, heights = column(history, "time"), column(history, "tool_displacement")
    assert np.all(np.diff(heights) > -1e-12)
    at = {time: last_of_segment(history, time)["tool_displacement"] for time in (1.0, 7.0, 67.0)}
    assert at[7.0] - at[1.0] > 20e-6
    late = times > 7.0
    speeds = np.diff(heights[late]) / np.diff(times[late])
    assert np.all(np.diff(speeds) < 1e-12)
    slow = finished(scene(TOOLS["plate"], {"hold": "1 s", "force": "2 N"}), folder / "slow")
    assert at[67.0] == pytest.approx(slow[-1]["tool_displacement"], rel=1e-4)
    rigid = laws | {"compaction": {}, "relaxation": {"branches": [{"share": 0.5, "time": "1e6 s"}]}}
    stiff = finished(scene(TOOLS["plate"], {"hold": "1 s", "force": "2 N"}, laws=rigid), folder / "stiff")
    assert stiff[-1]["tool_displacement"] < at[1.0] < at[67.0]


STEPS = {"small": {"largest_step": "1 s"}, "large": {"first_step": "2.5 s", "largest_step": "2.5 s"}}


@pytest.mark.parametrize(
    ("roll", "steps"),
    [
        pytest.param(False, "small", marks=pytest.mark.serial),
        pytest.param(True, "small", marks=pytest.mark.two_ranks),
        pytest.param(False, "large", marks=pytest.mark.serial),
    ],
)
def test_a_roller_travels_under_a_constant_force(folder, roll, steps):
    """Over the stack from inside towards its free end, which it comes near: it sinks there, its force stays."""
    tool = TOOLS["cylinder"] | {"position": ["4 mm", "0 mm"]}
    travel = {"travel": ["5 mm", "0 mm", "0 mm"], "speed": "1 mm/s", "roll": roll}
    path = [{"hold": "5 s", "force": "0.1 N"}, travel | {"force": "0.1 N"}]
    solver = STEPS[steps]
    history = finished(scene(tool, *path, solver=solver), folder / "force")
    check_ramp(history, 0.0, 5.0, 0.0, 0.1)
    check_ramp(history, 5.0, 10.0, 0.1, 0.1)
    start, end = (last_of_segment(history, time)["tool_displacement"] for time in (5.0, 10.0))
    given = finished(scene(tool, down(start), travel, down(end - start), solver=solver), folder / "height")
    assert given[-1]["tool_force"] == pytest.approx(0.1, rel=1e-5)
    assert abs(end - start) > 1e-6


def state_of(problem):
    control = problem.contacts.controls[0]
    return [
        problem.displacement.x.array.copy(),
        problem.contacts.tools[0].tip.value.copy(),
        np.array([problem.contacts.tools[0].height_offset, *control.state.committed]),
        problem.contacts.tools[0].nodal_forces(),
        problem.contacts.layers[0].gaps(),
    ]


@pytest.mark.parametrize("name", TOOLS)
def test_a_forced_failure_restores_the_height_bit_for_bit(name):
    path = [{"hold": "4 s", "force": "0.1 N"}, {"hold": "4 s", "force": "0.3 N"}]
    table = scene(TOOLS[name], *path).table()
    problem, newton = build(table)
    step = step_of(problem, newton)
    for time, size in ((0.0, 0.0), (0.0, 1.0), (1.0, 1.5), (2.5, 1.5), (4.0, 0.5)):
        outcome = step.attempt(time, size)
        assert outcome.converged, outcome.reason
        step.commit()
    before, residual = state_of(problem), newton.evaluate_residual()
    expected = 0.1 + 0.2 * 0.5 / 4
    assert 4 * problem.contacts.tools[0].force()[2] == pytest.approx(expected, rel=1e-6)
    assert problem.contacts.tools[0].height_offset < -1e-5

    generous = newton.settings
    newton.convergence.settings = generous.model_copy(update={"max_iterations": 1})
    step.begin(4.5, 2.0)
    assert not newton.solve().converged
    assert problem.contacts.tools[0].height_offset != before[2][0]
    step.rollback(4.5)

    for old, new in zip(before, state_of(problem), strict=True):
        assert np.array_equal(old, new)
    assert np.array_equal(residual, newton.evaluate_residual())
    newton.convergence.settings = generous
    assert step.attempt(4.5, 1.0).converged
    step.commit()
    assert 4 * problem.contacts.tools[0].force()[2] == pytest.approx(0.1 + 0.2 * 1.5 / 4, rel=1e-6)


def test_two_tools_carry_a_force_each(folder):
    """A roller at the middle and one beside it, each with a force of its own: their heights are coupled unknowns."""
    rollers = [
        {"width": "infinite", "path": [{"hold": "5 s", "force": "0.1 N"}]},
        {"width": "infinite", "position": ["8 mm", "0 mm"], "path": [{"hold": "5 s", "force": "0.04 N"}]},
    ]
    both = scene(TOOLS["cylinder"], {"hold": "5 s"}).table() | {"tool": rollers}
    history = finished(Scene.from_table(both), folder)
    assert history[-1]["tool_force"] == pytest.approx(0.1, rel=1e-6)
    assert history[-1]["tool_force_2"] == pytest.approx(0.04, rel=1e-6)
    missing = history[-1]["support_force"] - history[-1]["weight"] - 0.14
    assert abs(missing) < 1e-6 * 0.14


@pytest.mark.parametrize("name", TOOLS)
def test_a_force_that_is_lost_in_round_off_is_refused_with_the_one_that_would_do(folder, name):
    table = scene(TOOLS[name], down(1e-4), {"hold": "5 s", "force": "1e-9 N"})
    with pytest.raises(SceneError, match=r"tool.path.1.force = 1e-09 N: below what round-off leaves") as caught:
        run(table, folder / "none")
    assert COMM.rank or not (folder / "none").exists()
    enough = re.search(r"at least (\S+ N)", str(caught.value))[1]
    history = finished(scene(TOOLS[name], {"hold": "5 s", "force": enough}), folder / "run")
    assert history[-1]["tool_force"] == pytest.approx(float(enough.split()[0]), rel=1e-3)
