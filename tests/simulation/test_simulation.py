"""Whole runs: the reference figures, balance of forces, outputs read back, extension by a law and a tool."""

import csv
import json
import subprocess
import sys

import meshio
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from program import DEMOS

from ncf_fenicsx import Scene, run
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.output.results_folder import FILES, prepare_folder
from ncf_fenicsx.parameters.kinds import _kinds
from ncf_fenicsx.parameters.units import PositiveLength
from ncf_fenicsx.tools.rigid_surface import Tool

COMM = MPI.COMM_WORLD

LONG_ROLLER = DEMOS / "long_roller.toml"


def column(result, name):
    return np.array([row[name] for row in result.history])


def deformed(folder):
    """Deformed nodes in m of the last field file."""
    mesh = meshio.read(sorted((folder / "fields").glob("*.vtu"))[-1])
    return mesh.points + mesh.point_data["displacement"]


def check_balance(result):
    """Tool force equals support force minus weight in every step."""
    missing = column(result, "support_force") - column(result, "weight") - column(result, "tool_force")
    scale = np.maximum(column(result, "tool_force"), column(result, "weight"))
    assert np.abs(missing / scale).max() < 1e-6
    loaded = column(result, "tool_force") > 0
    assert np.abs(missing[loaded] / column(result, "tool_force")[loaded]).max() < 1e-6


def test_roller_agrees_with_the_independent_figures(folder):
    result = run(Scene.read(LONG_ROLLER), folder)
    assert result.done
    assert column(result, "newton_iterations").sum() <= 60
    assert column(result, "step_cuts").sum() == 0
    assert result.history[-1]["vf_max"] == pytest.approx(0.4635, rel=0.02)
    assert result.history[-1]["tool_force"] == pytest.approx(0.2275, rel=0.02)
    assert result.history[-1]["weight"] == pytest.approx(4 * 4 * 1.425 * 9.81 * 0.03 * 0.015, rel=1e-12)
    check_balance(result)


@pytest.mark.two_ranks
def test_roller_on_a_finer_mesh_with_ten_times_the_penalties(folder):
    finer = ["stack.divisions=[60, 4]", "tool.penalty=1e10 Pa/m", "interface.penalty=1e9 Pa/m"]
    result = run(Scene.read(LONG_ROLLER, finer), folder)
    assert result.history[-1]["vf_max"] == pytest.approx(0.4670, rel=0.02)
    assert result.history[-1]["tool_force"] == pytest.approx(0.2362, rel=0.02)
    check_balance(result)


UNSEEN = ("output.picture=false", "output.report=false")


@pytest.mark.serial
@pytest.mark.parametrize(
    "mesh",
    [
        pytest.param(["stack.divisions=[16, 2]"], id="order 1"),
        pytest.param([], id="the whole scene", marks=pytest.mark.slow),
        pytest.param(["stack.order=2", "stack.divisions=[8, 2]"], id="order 2", marks=pytest.mark.slow),
    ],
)
def test_one_two_and_three_ranks_give_one_history(folder, mesh):
    histories = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks_{ranks}"
        command = [
            "mpirun",
            "-n",
            str(ranks),
            sys.executable,
            "-m",
            "ncf_fenicsx",
            "run",
            str(LONG_ROLLER),
            "--out",
            str(out),
            *(word for text in (*mesh, *UNSEEN) for word in ("--set", text)),
        ]
        subprocess.run(command, check=True, capture_output=True)
        with (out / "history.csv").open() as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        assert sum(row["newton_iterations"] for row in rows) <= 60
        assert sum(row["step_cuts"] for row in rows) == 0
        histories.append(rows)
    for other in histories[1:]:
        assert len(other) == len(histories[0])
        for one, two in zip(histories[0], other, strict=True):
            for name in set(one) - {"wall_time", "newton_iterations"}:
                small = name.startswith(("gap", "slip", "void", "wrinkle", "misalignment", "curvature", "vf_error"))
                floor = 1e-9 if small else 0.0  # of a thickness of 2e-3 m
                assert two[name] == pytest.approx(one[name], rel=1e-6, abs=floor), name


def test_the_fabric_under_a_plate_follows_its_law(folder):
    """Two layers under a flat plate, without weight: the force is the law's pressure at the layers' own Vf."""
    table = {
        "gravity": "0 m/s^2",
        "laws": {"rate": {"feed": "process"}},
        "stack": {"layers": 2, "size": ["4 mm", "2 mm"], "divisions": [2, 2], "through": [1, 2]},
        "interface": {"penalty": "1e10 Pa/m"},
        "tool": {
            "kind": "plate",
            "penalty": "1e10 Pa/m",
            "path": [{"travel": ["0 mm", "0 mm", "-1 mm"], "speed": "5 mm/min"}, {"hold": "2 s"}],
        },
        "solver": {"force_tolerance": 1e-11},
        "output": {"picture": False, "report": False},
    }
    scene = Scene.from_table(table)
    result = run(scene, folder)
    vf, vf0 = column(result, "vf_max"), scene.stack.initial_volume_fraction
    assert vf[-1] > 0.5
    assert column(result, "vf_min") == pytest.approx(vf, rel=1e-9)
    speeds = np.where(column(result, "time") > 12.0, 0.0, 5e-3 / 60)
    pressure = scene.laws.rate.factor(speeds) * scene.laws.compaction.pressure(vf, vf0)
    assert column(result, "tool_force") / (4 * 8e-6) == pytest.approx(pressure, rel=1e-8, abs=1e-9)
    stiffness = column(result, "tool_force")[-1] / (4 * 8e-6) / column(result, "penetration_max")[-1]
    moved = column(result, "tool_displacement")[-1] - column(result, "penetration_max")[-1]
    thickness = 4e-3 * vf0 / vf[-1]
    overlap = 4e-3 - moved - thickness
    assert overlap * stiffness == pytest.approx(-pressure[-1], rel=1e-6)  # the two layers overlap as the tool does


def test_layers_separate_only_where_they_may(table, folder):
    table["tool"]["path"] = [{"travel": ["0 mm", "0 mm", "-0.4 mm"], "speed": "1 mm/min"}]
    table["laws"] = {"rate": {"feed": "process"}}
    gaps = {}
    for kind in ("one_sided", "bonded"):
        result = run(Scene.from_table(table | {"interface": {"kind": kind}}), folder / kind)
        assert result.done
        gaps[kind] = result.history[-1].get("gap_max_1", 0.0)
    assert gaps["one_sided"] > 1e-6
    if COMM.rank == 0:
        nodes = {kind: len(np.unique(deformed(folder / kind).round(10), axis=0)) for kind in gaps}
        assert nodes["one_sided"] > nodes["bonded"] == 7 * 3 * 3  # bonded layers part nowhere


def test_outputs_read_back(table, folder):
    table |= {"output": {"fields_every": 3, "picture": True}, "laws": {"rate": {"feed": "process"}}}
    scene = Scene.from_table(table)
    result = run(scene, folder)
    if COMM.rank:
        return
    assert Scene.read(folder / "scene.toml") == scene
    with (folder / "history.csv").open() as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    assert rows == result.history
    last = sorted((folder / "fields").glob("*.vtu"))[-1]
    mesh = meshio.read(last)
    assert f'timestep="{rows[-1]["time"]!r}" part="0" file="fields/{last.name}"' in (folder / "fields.pvd").read_text()
    vf = mesh.cell_data_dict["volume_fraction"]["hexahedron"]
    layer = mesh.cell_data_dict["layer"]["hexahedron"]
    stress = mesh.cell_data_dict["stress_33"]["hexahedron"]
    assert vf.max() == pytest.approx(rows[-1]["vf_max"], rel=1e-12)
    assert vf[layer == 2].mean() == pytest.approx(rows[-1]["vf_mean_layer_2"], rel=1e-12)
    factor = scene.laws.rate.factor(scene.segments[0].speed)
    expected = -factor * Exponential().pressure(vf, scene.stack.initial_volume_fraction)
    assert stress == pytest.approx(expected, rel=0.05, abs=5)  # the mean of the law is not the law of the mean
    cells = (mesh.points + mesh.point_data["displacement"])[mesh.cells_dict["hexahedron"]]
    height = cells[:, 4:, 2].mean(axis=1) - cells[:, :4, 2].mean(axis=1)
    assert scene.stack.initial_volume_fraction * 2e-3 / height == pytest.approx(vf, rel=1e-3)
    record = json.loads((folder / "run.json").read_text())
    assert record["ending"] == "done"
    assert record["unknowns"] == 3 * len(mesh.points) == 3 * 2 * 2 * 7 * 3
    assert record["newton_iterations"] >= sum(row["newton_iterations"] for row in rows)
    assert {"mesh", "forms", "assembly", "solve", "output"} <= set(record["seconds"])
    assert record["peak_memory_mb"] > 50
    convergence = record["convergence"]
    assert convergence["increment_m"] == pytest.approx(1e-4 * 2e-3)
    assert 0 < convergence["unbalanced_force_of_round_off_N"] < 1e-6
    assert (folder / "summary.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.serial
def test_overwriting_leaves_nothing_of_the_old_run_and_all_else(folder):
    old = [folder / "fields" / "0042.vtu", *(folder / name for name in FILES)]
    (folder / "fields").mkdir()
    for path in [*old, folder / "notes.txt"]:
        path.write_text("old")
    prepare_folder(folder)
    assert not any(path.exists() for path in old)
    assert (folder / "notes.txt").read_text() == "old"


def test_a_run_that_cannot_go_on_stops_with_its_reason_and_its_last_good_state(table, folder):
    table["solver"] = {"max_steps": 3}
    result = run(Scene.from_table(table), folder)
    assert not result.done
    assert "max_steps" in result.reason
    if COMM.rank == 0:
        last = meshio.read(sorted((folder / "fields").glob("*.vtu"))[-1])
        vf = last.cell_data_dict["volume_fraction"]["hexahedron"]
        assert vf.max() == pytest.approx(result.history[-1]["vf_max"], rel=1e-12)
        assert json.loads((folder / "run.json").read_text())["ending"] == "stopped"


def test_a_law_and_a_tool_defined_here_run_from_a_scene(table, folder):
    class Linear(Exponential):
        kind = "linear_of_this_test"

        def pressure(self, volume_fraction, initial_volume_fraction):
            return 1e5 * (volume_fraction - initial_volume_fraction)

        def tangent(self, volume_fraction, initial_volume_fraction):
            return 1e5 * volume_fraction**2 / initial_volume_fraction

    class Ball(Tool):
        kind = "ball_of_this_test"
        radius: PositiveLength = "5 mm"

        def signed_distance(self, point):
            return ufl.sqrt(point[0] ** 2 + point[1] ** 2 + (point[2] - 5e-3) ** 2) - 5e-3

        def section(self):
            return np.zeros((1, 2))

    try:
        plate = {"kind": "plate", "path": table["tool"]["path"]}
        table |= {
            "gravity": "0 m/s^2",
            "laws": {"compaction": {"kind": "linear_of_this_test"}, "rate": {"kind": "none"}},
        }
        flat = run(Scene.from_table(table | {"tool": plate}), folder / "law")
        vf = flat.history[-1]["vf_mean"]
        vf0 = Scene.from_table(table).stack.initial_volume_fraction
        assert flat.history[-1]["tool_force"] == pytest.approx(4 * 72e-6 * 1e5 * (vf - vf0), rel=1e-6)
        round_ = run(Scene.from_table(table | {"tool": plate | {"kind": "ball_of_this_test"}}), folder / "tool")
        assert 0 < round_.history[-1]["tool_force"] < 0.5 * flat.history[-1]["tool_force"]
    finally:
        del _kinds["compaction"]["linear_of_this_test"], _kinds["tool"]["ball_of_this_test"]
