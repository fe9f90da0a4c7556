"""Loss of stability: pivots and the critical mode against dense eigenvalues, and runs that go on past it."""

import json

import meshio
import numpy as np
import pytest
from assembled import COMM, assign, build, step_of
from program import DEMOS
from scipy.integrate import simpson

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mechanics.time_step import TimeStep
from ncf_fenicsx.output.energies import Energies
from ncf_fenicsx.simulation.step import AT_REST

pytestmark = pytest.mark.two_ranks

MODULUS, SHEAR = 1e9, 1e5


def pressed_sheet(strain):
    """A layer on weak ground, both of its ends pressed towards each other by a strain."""
    problem, newton = build(
        {
            "stack": {"layers": 1, "size": ["24 mm", "2 mm"], "divisions": [24, 1], "grading": [0, 0]},
            "laws": {
                "in_plane": {"modulus": f"{MODULUS} Pa"},
                "bending": {"modulus": "1 Pa"},
                "shear": {"modulus": f"{SHEAR} Pa"},
            },
            "duration": "1 s",
            "gravity": "0 m/s^2",
        }
    )
    assign(problem, lambda x: np.stack([-strain * x[0], 0 * x[0], 0 * x[0]]))
    return problem, newton


@pytest.mark.serial
@pytest.mark.parametrize("relative", [0.05, 2.0, 6.0])
def test_pivots_and_mode_are_those_of_the_dense_tangent(relative):
    problem, newton = pressed_sheet(relative * SHEAR / MODULUS)
    problem.last_iterate.x.array[:] = problem.displacement.x.array
    dense = newton.tangent.assemble().copy()
    dense.convert("dense")
    free = np.setdiff1d(np.arange(dense.getSize()[0]), problem.supports.dofs)
    values, vectors = np.linalg.eigh(dense.getDenseArray()[np.ix_(free, free)])
    value, mode = newton.critical_mode()
    assert value == pytest.approx(values[0], rel=1e-6)
    alike = abs(mode.ravel()[free] @ vectors[:, 0]) / np.linalg.norm(mode.ravel()[free])
    gap = np.diff(values[:2])[0] / abs(values[0])
    assert alike == pytest.approx(1, abs=1e-6) or gap < 1e-3
    assert np.abs(mode).max() == pytest.approx(1, rel=1e-12)
    assert newton._negative_pivots(1) == np.count_nonzero(values < 0)
    assert (np.count_nonzero(values < 0) > 0) == (relative > 1)


def test_pivots_of_an_iterate_before_are_no_loss_of_stability():
    problem, newton = pressed_sheet(2 * SHEAR / MODULUS)
    pressed, free = problem.displacement.x.array.copy(), 0.01 * problem.displacement.x.array

    def counted(at, solution):
        """Negative pivots told at a solution where factors are those at another state."""
        problem.displacement.x.array[:] = problem.last_iterate.x.array[:] = at
        newton.linear.factorise(newton.tangent.assemble())
        problem.displacement.x.array[:] = solution
        return newton._negative_pivots(1)

    assert counted(pressed, free) == 0
    assert counted(free, pressed) == 0
    lost = counted(pressed, pressed)
    assert lost > 0
    assert counted(pressed, free) == 0, "a solution may have been one of a step that failed"
    newton.unstable = True
    assert counted(pressed, free) == lost, "where stability is lost the factors at hand are enough"


def test_the_critical_mode_is_one_on_any_ranks():
    _, newton = pressed_sheet(2 * SHEAR / MODULUS)
    value, mode = newton.critical_mode()
    assert len(set(COMM.allgather(value))) == 1
    assert max(COMM.allgather(np.abs(mode).max())) == pytest.approx(1, rel=1e-12)


def wavelength_of(mesh):
    """Wavelength in m of the highest line between two layers in a mode of a quarter, with its mirror images."""
    lower = np.unique(mesh.cells_dict["hexahedron"][mesh.cell_data_dict["layer"]["hexahedron"] == 1])
    face = lower[np.isclose(mesh.points[lower, 2], 2e-3)]
    (x, y), deflection = mesh.points[face, :2].T, mesh.point_data["critical_mode"][face, 2]
    lines = []
    for along, across in ((x, y), (y, x)):
        for place in np.unique(across.round(9)):
            line = np.flatnonzero(np.isclose(across, place))
            line = line[np.argsort(along[line])]
            s, w = (
                np.concatenate([sign * half[:0:-1], half]) for sign, half in ((-1, along[line]), (1, deflection[line]))
            )
            lines.append((np.ptp(w), s, w))
    _, s, w = max(lines, key=lambda line: line[0])
    v = w - np.trapezoid(w, s) / np.ptp(s)
    crossings = np.flatnonzero(np.diff(v > 0))
    zeros = s[crossings] - v[crossings] * np.diff(s)[crossings] / np.diff(v)[crossings]
    return 2 * np.ptp(zeros) / (len(zeros) - 1)


def test_a_run_says_when_it_loses_stability_and_writes_the_mode(table, folder):
    """Layers with hardly any transverse shear crimp under the roller; with a hundred times more they do not."""
    stack = table["stack"] | {"size": ["12 mm", "12 mm"], "divisions": [10, 8]}
    tool = table["tool"] | {"width": "8 mm"}
    for shear, crimps in (("0.01 MPa", True), ("10 MPa", False)):
        changed = {
            "laws": {"shear": {"modulus": shear}},
            "output": {"picture": False, "report": False, "critical_mode": True},
        }
        changed["solver"] = {"max_steps": 15}  # the layers crimp in the tenth or so
        result = run(Scene.from_table(table | {"stack": stack, "tool": tool} | changed), folder / shear[:4])
        if COMM.rank:
            continue
        record = json.loads((result.folder / "run.json").read_text())
        lost = record["loss_of_stability"]
        pivots = [row["negative_pivots"] for row in result.history]
        assert (lost is not None) == crimps
        assert (result.folder / "critical_mode.vtu").exists() == crimps
        assert any(pivots) == crimps
        if crimps:
            assert lost["time"] == next(row["time"] for row in result.history if row["negative_pivots"])
            assert lost["eigenvalue"] < 0
            assert 0 < lost["wavelength"] < 24e-3  # the whole stack
            mesh = meshio.read(result.folder / "critical_mode.vtu")
            assert np.abs(mesh.point_data["critical_mode"]).max() == pytest.approx(1)
            assert lost["wavelength"] == pytest.approx(wavelength_of(mesh), rel=1e-6)


PRESSED = {
    "stack": {"layers": 1, "size": ["6 mm", "4 mm"], "divisions": [2, 1], "grading": [0, 0], "through": 4},
    "laws": {"rate": {"kind": "none"}},
    "tool": {"kind": "plate", "path": [{"travel": ["0 mm", "0 mm", "-0.1 mm"], "speed": "1 mm/min"}]},
    "solver": {"first_step": "0.2 s", "largest_step": "0.2 s"},
    "gravity": "0 m/s^2",
    "output": {"picture": False, "report": False},
}


def test_the_work_of_a_tool_is_the_integral_of_its_force(folder):
    result = run(Scene.from_table(PRESSED), folder)
    force, down = (np.array([row[name] for row in result.history]) for name in ("tool_force", "tool_displacement"))
    assert result.history[-1]["tool_work"] == pytest.approx(simpson(force, x=down), rel=1e-5)
    assert result.history[-1]["tool_work"] == pytest.approx(np.trapezoid(force, down), rel=1e-3)
    assert result.history[-1]["viscous_share"] == result.history[-1]["viscous_force"] == 0


def test_viscosity_resists_what_departs_from_the_drift_and_says_what_it_takes():
    """A layer pressed evenly from rest, v = V z / h: c V / 2 for each volume, c V^2 / 3 and second; then none."""
    problem, newton = build(PRESSED)
    energies = Energies(problem)
    steps = TimeStep(problem, lambda _time, size, effort: newton.solve(effort if size else AT_REST), energies.state)
    coefficient, size, speed, volume = 3e7, 0.2, 1e-3 / 60, 4 * 6e-3 * 4e-3 * 2e-3
    rows = []
    for time, step in ((0.0, 0.0), (0.0, size), (size, size)):
        steps.stabilise(coefficient if step else 0.0)
        assert steps.attempt(time, step).converged
        rows.append(steps.accept(lambda: energies.observe(steps.time)))
        steps.drift_on()
    rest, first, second = rows
    assert rest["viscous_force"] == rest["viscous_share"] == 0
    assert first["viscous_force"] == pytest.approx(coefficient * speed * volume / 2, rel=0.02)
    taken = first["viscous_share"] * first["tool_work"]
    assert taken == pytest.approx(coefficient * speed**2 / 3 * volume * size, rel=0.02)
    assert second["viscous_force"] < 0.02 * first["viscous_force"]


def test_no_viscosity_is_built_before_it_is_needed(table):
    problem, _ = build(table)
    step = step_of(problem)
    step.stabilise(0.0)
    assert step.viscosity is None
    assert "viscosity" not in problem.terms
    step.stabilise(1e7)
    assert "viscosity" in problem.terms


CRIMPING = {
    "stack": {"layers": 2, "size": ["12 mm", "12 mm"], "divisions": [6, 4], "grading": [0, 0]},
    "interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0},
    "laws": {"shear": {"modulus": "0.015 MPa"}},
    "tool": {"width": "8 mm", "path": [{"travel": ["0 mm", "0 mm", "-0.8 mm"], "speed": "1 mm/min"}]},
    "output": {"picture": False, "report": False, "fields_every": 1000},
}


@pytest.mark.serial
def test_a_stack_that_snaps_is_carried_on_by_a_viscosity_that_hardly_shows(folder):
    """Layers with hardly any transverse shear crimp: without it the run stops."""
    stops = run(Scene.from_table(CRIMPING | {"solver": {"stabilisation": "none"}}), folder / "stops")
    assert not stops.done
    assert "even with the smallest time step" in stops.reason
    ends = run(Scene.from_table(CRIMPING), folder / "ends")
    assert ends.done
    record = json.loads((ends.folder / "run.json").read_text())
    assert 0 < record["stabilised_from"] < stops.history[-1]["time"]
    before = [row for row in ends.history if row["time"] < record["stabilised_from"]]
    assert all(row["viscous_force"] == 0 for row in before)
    assert 0 < ends.history[-1]["viscous_share"] < 1e-4
    assert ends.history[-1]["viscous_force"] < 0.01 * ends.history[-1]["tool_force"]
    assert any(row["negative_pivots"] for row in before) == (record["loss_of_stability"] is not None)


@pytest.mark.serial
def test_a_run_goes_on_from_the_midst_of_a_snap(folder):
    """A step or two after the viscosity has come, while steps are small: it, its drift and its energy are kept."""
    table = CRIMPING | {"solver": {"max_steps": 60}}
    whole = run(Scene.from_table(table), folder / "whole").history
    came = next(k for k, row in enumerate(whole) if row["viscous_force"])
    assert came + 10 < len(whole)
    for stop in (came, came + 2):
        run(Scene.from_table(CRIMPING | {"solver": {"max_steps": stop}}), folder / str(stop))
        parts = run(Scene.from_table(table), folder / str(stop), restart=True).history
        for name in ("time", "tool_force", "viscous_force", "viscous_share", "newton_iterations"):
            assert [row[name] for row in parts] == pytest.approx([row[name] for row in whole], rel=1e-8), name


@pytest.mark.serial
def test_a_run_that_viscosity_has_taken_over_is_stopped(folder):
    result = run(Scene.from_table(CRIMPING | {"solver": {"viscous_share": 1e-8}}), folder)
    assert not result.done
    assert "no solution of the laws" in result.reason
    assert result.history[-1]["viscous_share"] > 1e-8 >= result.history[-2]["viscous_share"]
    assert (folder / "checkpoint.h5").is_file()


@pytest.mark.serial
def test_a_push_along_the_critical_mode_leads_to_the_stable_branch(folder):
    """A long roller 2.5 mm into 8 mm: without a push the run stays on the branch that is no longer stable."""
    long_roller = DEMOS / "long_roller.toml"
    settings = [
        "stack.divisions=[20, 1]",
        'tool.path.0.travel=["0 mm", "0 mm", "-2.5 mm"]',
        "output.picture=false",
        "output.report=false",
    ]
    stays = run(Scene.read(long_roller, settings), folder / "stays").history
    lost = next(k for k, row in enumerate(stays) if row["negative_pivots"])
    assert all(row["negative_pivots"] > 0 for row in stays[lost:])
    left = run(Scene.read(long_roller, [*settings, "solver.perturbation=0.05 mm"]), folder / "left").history
    assert [row["tool_force"] for row in left[: lost + 1]] == [row["tool_force"] for row in stays[: lost + 1]]
    assert all(row["negative_pivots"] == 0 for row in left[lost + 1 :])
    assert left[-1]["tool_force"] < 0.99 * stays[-1]["tool_force"]
    assert 0 < left[-1]["viscous_share"] < 1e-3
