"""Central differences: frequencies and decay against closed forms, the stable step, and agreement with equilibrium."""

import json
from itertools import pairwise

import numpy as np
import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mechanics.time_step import TimeStep, move_tools
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.scene.settings import Explicit
from ncf_fenicsx.simulation.central_differences import CentralDifferences
from ncf_fenicsx.simulation.explicit import COLUMNS, ExplicitRun, run_explicit
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.solver.timing import Phases
from ncf_fenicsx.study.comparison import Comparison, Curves

pytestmark = pytest.mark.two_ranks

COMM = MPI.COMM_WORLD
HEIGHT, LAYERS, MODULUS = 2e-3, 4, 1e6
COLUMN = {
    "duration": "1 s",
    "gravity": "0 m/s^2",
    "stack": {"layers": LAYERS, "size": ["1 mm", "1 mm"], "divisions": [1, 1], "grading": [0, 0]},
    "interface": {"kind": "bonded"},
    "laws": {"solid": {"modulus": f"{MODULUS} Pa", "poisson": 0}},
}
STRIP = {
    "stack": {"layers": 2, "size": ["8 mm", "0.5 mm"], "divisions": [12, 1], "grading": [0.7, 0]},
    "laws": {"in_plane": {"modulus": "24.2 MPa"}},
    "tool": {
        "width": "infinite",
        "penalty": 100,
        "path": [{"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}],
    },
    "output": {"picture": False, "report": False},
}
COARSE = STRIP | {"stack": STRIP["stack"] | {"divisions": [6, 1], "order": 2}}


def marched(table, **settings):
    scene = Scene.from_table(table)
    problem = Problem(scene, build_mesh(scene, COMM))
    quiet = {"mass_scaling": 1, "time_scaling": 1, "bulk_viscosity": 0, "damping": 0}
    return problem, CentralDifferences(problem, Explicit(**quiet | settings))


def closed_form_frequency(density):
    """Lowest angular frequency of a chain of equal masses and springs, half a mass at its free end, in 1/s."""
    return 2 * np.sqrt(MODULUS / density) / HEIGHT * np.sin(np.pi / (4 * LAYERS))


def swing(problem, differences, times):
    """Height in nm of the column's top at times after it was pulled along its lowest mode by 1 nm, and let go."""
    mode = np.sin(0.5 * np.pi * problem.space.tabulate_dof_coordinates()[:, 2] / (LAYERS * HEIGHT))
    step = TimeStep(problem, differences.solve, predicts=False)
    step.push(np.outer(1e-9 * mode, [0, 0, 1]).ravel())
    heights = []
    for start, end in pairwise(times):
        step.begin(start, end - start)
        differences.solve(start, end - start)
        step.commit()
        heights.append(1e9 * problem.displacement.x.array.reshape(-1, 3)[mode > 1 - 1e-9, 2].sum() / 4)
    return COMM.allreduce(np.array(heights))  # one element: on one rank


def test_a_column_that_is_let_go_swings_with_its_frequency_for_ever():
    problem, differences = marched(COLUMN, safety=0.05)
    times = np.linspace(0, 4, 33) * 2 * np.pi / closed_form_frequency(differences.density)
    expected = np.cos(closed_form_frequency(differences.density) * times[1:])
    assert swing(problem, differences, times) == pytest.approx(expected, abs=0.01)


def test_damping_is_the_share_of_the_critical_one():
    problem, differences = marched(COLUMN, damping=0.05, safety=0.05)
    frequency = closed_form_frequency(differences.density)
    times = np.linspace(0, 4, 33) * 2 * np.pi / frequency
    decay = 0.05 * differences.lowest_frequency
    damped, times_after = np.sqrt(frequency**2 - decay**2), times[1:]
    expected = np.exp(-decay * times_after) * (
        np.cos(damped * times_after) + decay / damped * np.sin(damped * times_after)
    )
    assert swing(problem, differences, times) == pytest.approx(expected, abs=0.01)
    assert expected[-1] < 0.35
    assert differences.damped > 0


def test_scaled_speed_is_mass_by_its_square():
    results = []
    for scaling in ({"mass_scaling": 400.0}, {"mass_scaling": 4.0, "time_scaling": 10.0}):
        problem, differences = marched(COLUMN, **scaling)
        results.append(swing(problem, differences, np.linspace(0, 1e-2, 5)))
    assert results[0] == pytest.approx(results[1], rel=1e-12)


@pytest.mark.serial
@pytest.mark.parametrize("table", [STRIP, COLUMN, COARSE], ids=["fabric under a tool", "solid", "order 2"])
def test_the_stable_step_is_below_that_of_the_whole_and_not_by_much(table):
    problem, differences = marched(table)
    if problem.scene.tool:
        move_tools(problem, 0.0, 1.0)  # the tool a bit lower: its springs are in the tangent
    matrix = Newton(problem, problem.scene.solver, Phases()).tangent.assemble()
    rows, columns, values = matrix.getValuesCSR()
    stiffness = np.zeros(matrix.size)
    for row in range(len(rows) - 1):
        stiffness[row, columns[rows[row] : rows[row + 1]]] = values[rows[row] : rows[row + 1]]
    free = np.flatnonzero(differences._free)
    mass = np.sqrt(differences._mass[free])
    highest = np.sqrt(np.linalg.eigvalsh(stiffness[np.ix_(free, free)] / np.outer(mass, mass))[-1])
    bound = differences.stable.update()
    assert highest <= 1.001 * bound
    assert bound < 1.6 * highest


@pytest.mark.serial
def test_beyond_the_stable_step_it_explodes():
    problem, differences = marched(COLUMN)
    differences.settings = differences.settings.model_copy(update={"safety": 1.6})
    assert not abs(swing(problem, differences, [0.0, 200 * differences.largest_step()])[-1]) < 1e6


@pytest.mark.serial
def test_an_explosion_is_named(folder):
    explicit = {"safety": 1.0, "rows": 3, "time_scaling": 1e4}
    table = STRIP | {"explicit": explicit, "gravity": "1e8 m/s^2"}
    result = run_explicit(Scene.from_table(table), folder)
    assert not result.done
    assert "inverted" in result.reason or "without bound" in result.reason


DOWN = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}
UP = {"travel": ["0 mm", "0 mm", "0.3 mm"], "speed": "1 mm/min"}
RELAXING = {
    "laws": STRIP["laws"] | {"relaxation": {"branches": [{"time": "5 s"}]}, "unloading": {}},
    "tool": STRIP["tool"] | {"path": [DOWN, {"hold": "10 s"}, UP]},
}


def test_a_fabric_that_relaxes_has_no_forces_before_the_first_step():
    _, differences = marched(STRIP | RELAXING | {"gravity": "0 m/s^2"})
    assert np.abs(differences.forces).max(initial=0.0) < 1e-9


@pytest.mark.serial
@pytest.mark.parametrize(
    "change", [{}, pytest.param(RELAXING, marks=pytest.mark.slow)], ids=["press", "press, hold, lift"]
)
def test_it_agrees_with_equilibrium_where_inertia_is_small(folder, change):
    explicit = {"time_scaling": 250.0, "rows": 60}
    marched_ = run_explicit(Scene.from_table(STRIP | change | {"explicit": explicit}), folder / "explicit")
    assert marched_.done, marched_.reason
    steps = {"first_step": "0.3 s", "largest_step": "0.3 s"}
    still = run(Scene.from_table(STRIP | change | {"solver": steps}), folder / "implicit")
    ours, theirs = (Curves.read(result.folder / "history.csv") for result in (marched_, still))
    force, vf = Comparison(ours, theirs, ["tool_force", "vf_max"]).differences
    assert force.mean_square < 0.02
    assert abs(force.last) < 0.02
    assert abs(vf.last) < 0.005
    assert vf.mean_square < 0.005
    record = json.loads((marched_.folder / "run.json").read_text())
    assert record["explicit"]["kinetic_share"] < 0.01
    assert record["explicit"]["quasi_static"]
    assert set(COLUMNS) <= set(marched_.history[0])


def test_a_run_that_is_too_fast_is_not_called_quasi_static(folder):
    fast = {"time_scaling": 3e4, "rows": 10}
    result = run_explicit(Scene.from_table(STRIP | {"explicit": fast}), folder)
    assert not result.done
    assert "not quasi-static: the kinetic energy was up to" in result.reason
    assert max(row["kinetic_share"] for row in result.history) > 0.05
    if COMM.rank == 0:
        assert not json.loads((folder / "run.json").read_text())["explicit"]["quasi_static"]
    before = (folder / "history.csv").read_bytes()
    with pytest.raises(SceneError, match="results of an explicit march, which has no checkpoints"):
        run(Scene.from_table(STRIP), folder, restart=True)
    assert (folder / "history.csv").read_bytes() == before


def test_tools_under_a_force_are_refused(folder):
    tool = STRIP["tool"] | {"path": [{"hold": "1 s", "force": "1 N"}]}
    with pytest.raises(SceneError, match="expected tools whose height is given"):
        run_explicit(Scene.from_table(STRIP | {"tool": tool}), folder / "none")
    assert not (folder / "none").exists()


def test_a_scene_without_a_tool_is_refused(folder):
    with pytest.raises(SceneError, match="explicit: tool: expected one"):
        run_explicit(Scene.from_table(COLUMN), folder / "none")
    assert not (folder / "none").exists()


@pytest.mark.parametrize(
    ("rows", "share"),
    [
        ([(1.0, 0.1, 0.4)], 0.8),
        ([(1.0, 0.1, 0.4), (10.0, 0.0, 2.0)], 0.8),
        ([(1.0, 0.9, 0.3)], 1.0),  # all the work has gone into motion and damping
        ([(1.0, 0.9, 0.3), (100.0, 0.0, 10.0)], 1 / 9),  # a start that hardly matters
    ],
)
def test_the_share_of_kinetic_energy(rows, share):
    marched = object.__new__(ExplicitRun)
    marched.history = [
        {
            "tool_work": work,
            "damped_share": damped,
            "kinetic_energy": kinetic,
            "kinetic_share": kinetic / internal if (internal := work * (1 - damped) - kinetic) > 0 else 1.0,
        }
        for work, damped, kinetic in rows
    ]
    assert marched.kinetic_share == pytest.approx(share)
