"""Nothing is lost: restarts repeat a history, kills at random moments, signals, folders that cannot be written."""

import csv
import os
import random
import signal
import subprocess
import sys
import tomllib

import meshio
import numpy as np
import pytest
from mpi4py import MPI
from program import DEMOS, ENVIRONMENT

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.output.checkpoint import NAME
from ncf_fenicsx.output.safe_files import ResultError, replace

COMM = MPI.COMM_WORLD

DOWN = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}
UP = {"travel": ["0 mm", "0 mm", "0.2 mm"], "speed": "2 mm/min"}
ALONG = {"travel": ["1.5 mm", "0 mm", "0 mm"], "speed": "0.5 mm/s", "roll": True}
CASES = {
    "penalty and stitches": {},
    "multipliers": {"contact": {"kind": "augmented_lagrangian"}},
    "friction of a travelling roller": {"friction": {"coefficient": 0.2}},
    "nitsche": {"contact": {"kind": "nitsche"}},
}


def contact_case(name):
    ways = CASES[name]
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [[6, 2], [8, 3]], "grading": [0, 0]},
        "interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0} | ways,
        "tool": {"width": "infinite", "path": [DOWN, ALONG, UP]} | ways,
        "laws": {"shear": {"modulus": "2 MPa"}, "rate": {"feed": "process"}},
    }


def law_case():
    relaxation = {"kind": "maxwell", "branches": [{"share": 0.3, "time": "5 s"}]}
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": {"kind": "plate", "path": [DOWN, {"hold": "20 s"}, UP]},
        "laws": {"unloading": {"kind": "permanent_set"}, "relaxation": relaxation},
    }


def force_case():
    pressed = {"hold": "10 s", "force": "0.1 N"}
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": {"width": "infinite", "path": [pressed, ALONG | {"force": "0.1 N"}]},
        "laws": {"shear": {"modulus": "2 MPa"}, "rate": {"feed": "process"}},
    }


TABLES = {name: contact_case(name) for name in CASES} | {"memory of the laws": law_case(), "force": force_case()}
TABLES["order 2"] = contact_case("nitsche")
TABLES["order 2"]["stack"] |= {"order": 2, "divisions": [[3, 1], [4, 2]]}
COST = {"wall_time"}
ROUND_OFF = 1e-15
"""Of places in m."""


def compare(history, expected, tolerance=1e-10):
    """Histories agree to a tolerance of each column's largest value."""
    assert len(history) == len(expected)
    for name in set(expected[0]) - COST:
        one, two = (np.array([row[name] for row in rows]) for rows in (history, expected))
        assert np.abs(one - two).max() <= tolerance * np.abs(two).max() + ROUND_OFF, name


@pytest.mark.parametrize("name", TABLES)
def test_a_run_that_goes_on_repeats_the_history_of_one_that_never_stopped(folder, name):
    table = TABLES[name] | {"output": {"picture": False}}
    whole = run(Scene.from_table(table), folder / "whole")
    assert whole.done, whole.reason
    steps = len(whole.history) - 1
    assert steps > 8
    for stop in (0, steps // 3, 2 * steps // 3):
        scene = Scene.from_table(table | {"solver": {"max_steps": max(stop, 1)}})
        run(scene, folder / f"parts_{stop}", restart=stop > 0)
        parts = run(Scene.from_table(table), folder / f"parts_{stop}", restart=True)
        assert parts.done, parts.reason
        compare(parts.history, whole.history)
    if COMM.rank == 0:
        last = [meshio.read(sorted((folder / part).glob("fields/*.vtu"))[-1]) for part in ("whole", f"parts_{stop}")]
        assert [len(list((folder / part).glob("fields/*.vtu"))) for part in ("whole", f"parts_{stop}")] == [
            steps + 1
        ] * 2
        moved = [mesh.point_data["displacement"] for mesh in last]
        assert np.abs(moved[0] - moved[1]).max() < 1e-10 * np.abs(moved[0]).max()


def test_a_rank_without_a_cell_saves_and_goes_on(folder):
    table = law_case() | {"output": {"picture": False}}
    table["stack"] = {"layers": 1, "size": ["4 mm", "4 mm"], "divisions": [1, 1]}
    whole = run(Scene.from_table(table), folder / "whole")
    run(Scene.from_table(table | {"solver": {"max_steps": 3}}), folder / "parts")
    parts = run(Scene.from_table(table), folder / "parts", restart=True)
    compare(parts.history, whole.history)


def test_a_checkpoint_of_another_mesh_or_scene_is_refused(folder):
    table = law_case() | {"output": {"picture": False}, "solver": {"max_steps": 2}}
    run(Scene.from_table(table), folder / "run")
    other = table | {"stack": table["stack"] | {"divisions": [5, 2]}}
    with pytest.raises(SceneError, match=r"rows of .*; expected"):
        run(Scene.from_table(other), folder / "run", restart=True)
    with pytest.raises(SceneError, match="parts are not those of the scene"):
        run(Scene.from_table(table | {"laws": {}}), folder / "run", restart=True)


def test_a_damaged_checkpoint_is_one_line(folder):
    table = law_case() | {"output": {"picture": False}, "solver": {"max_steps": 2}}
    run(Scene.from_table(table), folder / "run")
    if COMM.rank == 0:
        content = (folder / "run" / NAME).read_bytes()
        (folder / "run" / NAME).write_bytes(content[: len(content) // 2])
    COMM.barrier()
    with pytest.raises(SceneError, match="cannot be read; expected the checkpoint of a run"):
        run(Scene.from_table(table), folder / "run", restart=True)


SLOW_ROLLER = [
    DEMOS / "long_roller.toml",
    *("--set", "stack.divisions=[12, 2]"),
    *("--set", "solver.largest_step=0.2 s", "--set", "solver.first_step=0.2 s"),
    *("--set", "output.picture=false", "--set", "output.checkpoint_every=1"),
]


def start(*arguments, ranks=1, code="from ncf_fenicsx.cli import main; main()"):
    """A run in a process of its own, its output in a pipe, in a process group that signals go to."""
    command = [sys.executable, "-c", code, "run", *map(str, arguments)]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    return subprocess.Popen(
        command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def history(folder):
    with (folder / "history.csv").open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def ranks_of(process):
    """Process numbers of the Python programs that a run consists of."""
    listed = subprocess.run(["ps", "-eo", "pid,pgid,sid,comm"], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in listed.splitlines()[1:]]
    return [int(row[0]) for row in rows if int(row[2]) == process.pid and row[3].startswith("python")]


def kill_after(process, seconds, one_rank):
    """Kill all of a run, or one of its ranks, some seconds after it has begun to compile its forms."""
    while "compiling" not in process.stdout.readline():
        assert process.poll() is None
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        if one_rank:
            os.kill(ranks_of(process)[-1], signal.SIGKILL)
        else:
            os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


@pytest.mark.serial
def test_killed_at_ten_random_moments_a_run_ends_with_the_same_history(tmp_path):
    out, moments = tmp_path / "killed", random.Random(4)
    whole = start(*SLOW_ROLLER, "--out", tmp_path / "whole")
    assert whole.wait() == 0
    reached = []
    for number in range(10):
        ranks = 1 + number % 2
        arguments = ["--restart", out] if (out / "scene.toml").exists() else [*SLOW_ROLLER, "--out", out]
        kill_after(start(*arguments, ranks=ranks), moments.uniform(0.2, 1.2), one_rank=ranks == 2)
        reached.append(len(history(out)) if (out / "history.csv").exists() else 0)
    ended = start("--restart", out)
    ended.communicate()
    assert ended.returncode == 0
    assert 0 < max(reached) < len(history(out))  # it was killed on the way, not before or after
    compare(history(out), history(tmp_path / "whole"))


HALF_WRITTEN = """
import os, signal
from ncf_fenicsx.output import checkpoint
whole = checkpoint._write
def half(path, parts, progress):
    whole(path, parts, progress)
    if progress["steps"] == 7:
        os.truncate(path, os.path.getsize(path) // 2)
        os.kill(os.getpid(), signal.SIGKILL)
checkpoint._write = half
from ncf_fenicsx.cli import main
main()
"""


@pytest.mark.serial
def test_killed_while_a_checkpoint_is_written_a_run_goes_on_from_the_one_before(tmp_path):
    killed = start(*SLOW_ROLLER, "--out", tmp_path / "killed", code=HALF_WRITTEN)
    killed.communicate()
    assert killed.returncode == -signal.SIGKILL
    ended = start("--restart", tmp_path / "killed")
    said = ended.communicate()[0]
    assert ended.returncode == 0
    assert "going on from 1.2 s" in said  # six steps of a fifth of a second
    whole = start(*SLOW_ROLLER, "--out", tmp_path / "whole")
    whole.communicate()
    compare(history(tmp_path / "killed"), history(tmp_path / "whole"))


@pytest.mark.serial
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_signal_ends_a_run_with_its_last_good_state_saved(tmp_path, number, ranks):
    process = start(*SLOW_ROLLER, "--set", "output.checkpoint_every=1000", "--out", tmp_path / "run", ranks=ranks)
    for line in process.stdout:
        if "Vf max" in line and float(line.split()[0]) >= 2:
            break
    os.kill(ranks_of(process)[-1], number)
    said, errors = process.communicate()
    assert process.returncode == 1
    assert f"stopped: interrupted by {number.name}" in said
    assert "Traceback" not in errors
    record = (tmp_path / "run" / "run.json").read_text()
    assert f"interrupted by {number.name}" in record
    last = history(tmp_path / "run")[-1]["time"]
    assert 1.9 < last < 30
    ended = start("--restart", tmp_path / "run", "--set", f"solver.max_steps={len(history(tmp_path / 'run')) + 1}")
    assert f"going on from {last:.6g} s" in ended.communicate()[0]


LIMITED = """
import resource
from ncf_fenicsx.simulation import simulation
begin = simulation.Simulation._start
def limited(self):
    resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
    return begin(self)
simulation.Simulation._start = limited
from ncf_fenicsx.cli import main
main()
"""


@pytest.mark.serial
@pytest.mark.parametrize(("limit", "file"), [(1000, "history.csv"), (12000, "0000.vtu"), (30000, "checkpoint.h5")])
def test_a_full_disk_is_one_line_and_what_was_written_stays(tmp_path, limit, file):
    """A limit on the size of files in bytes, from the start of the run on, stands for the disk."""
    ended = start(*SLOW_ROLLER, "--out", tmp_path / "run", code=LIMITED.format(limit=limit))
    errors = ended.communicate()[1]
    assert ended.returncode == 1
    assert errors.count("\n") == 1, errors
    assert f"{file}: File too large; what was written before stays readable" in errors
    assert tomllib.loads((tmp_path / "run" / "scene.toml").read_text())
    for row in history(tmp_path / "run"):
        assert None not in row.values()
    for fields in (tmp_path / "run" / "fields").glob("*.vtu"):
        assert len(meshio.read(fields).points)


@pytest.mark.serial
def test_a_read_only_folder_is_one_line(tmp_path):
    (tmp_path / "closed").mkdir(mode=0o555)
    ended = start(*SLOW_ROLLER, "--out", tmp_path / "closed" / "run")
    errors = ended.communicate()[1]
    assert ended.returncode == 2
    assert errors.count("\n") == 1
    assert "cannot be written to" in errors


def test_a_file_is_replaced_only_when_the_new_one_is_whole(tmp_path):
    target = tmp_path / "file.txt"
    replace(target, lambda path: path.write_text("old"))

    def fail(path):
        path.write_text("ne")
        raise OSError(28, "No space left on device")

    with pytest.raises(ResultError, match=r"file\.txt: No space left on device"):
        replace(target, fail)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]
