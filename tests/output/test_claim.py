"""A results folder belongs to one run at a time, and to none that is dead."""

import errno
import fcntl
import os
import signal
import subprocess
import sys

import pytest
from mpi4py import MPI
from program import ENVIRONMENT
from runs_apart import SLOW_ROLLER, compare, history, start

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.output.claim import Claim
from ncf_fenicsx.output.results_folder import CLAIM

pytestmark = pytest.mark.serial
ALONE = MPI.COMM_SELF


def test_a_folder_is_claimed_once_and_free_again_after(tmp_path):
    folder = tmp_path / "deep" / "run"
    with Claim(folder, ALONE, overwrite=False):
        with pytest.raises(SceneError) as caught, Claim(folder, ALONE, overwrite=True):
            pass
        assert f"another run writes there, process {os.getpid()} on " in str(caught.value)
        assert " since " in str(caught.value)
        assert [path.name for path in folder.iterdir()] == [CLAIM]
    assert list(tmp_path.iterdir()) == []
    with Claim(folder, ALONE, overwrite=False):
        (folder / "history.csv").write_text("kept")
    assert [path.name for path in folder.iterdir()] == ["history.csv"]


def test_a_refused_folder_stays_as_it_was(tmp_path):
    (tmp_path / "kept").write_text("precious")
    with pytest.raises(SceneError, match="holds results already"), Claim(tmp_path, ALONE, overwrite=False):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_a_run_that_fails_leaves_no_claim(tmp_path, table):
    table["mould"] = {"kind": "sphere", "shape": "concave", "radius": "50 mm"}
    with pytest.raises(SceneError, match="inside the stack"):
        run(Scene.from_table(table), tmp_path / "a" / "b", ALONE)
    assert list(tmp_path.iterdir()) == []


def test_a_claim_whose_holder_was_killed_is_none(tmp_path):
    """And it is told whose results those are."""
    code = (
        "import os, signal, sys; from pathlib import Path; from mpi4py import MPI\n"
        "from ncf_fenicsx.output.claim import Claim\n"
        "Claim(Path(sys.argv[1]), MPI.COMM_SELF, True).__enter__()\n"
        "Path(sys.argv[1], 'history.csv').write_text('half')\nos.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "run")], env=ENVIRONMENT, check=False)
    left = (tmp_path / "run" / CLAIM).read_text()
    for _ in range(2):
        with pytest.raises(SceneError) as caught, Claim(tmp_path / "run", ALONE, overwrite=False):
            pass
        assert f"holds results of a run that was killed, {left.strip()}; go on with --restart" in str(caught.value)
    with Claim(tmp_path / "run", ALONE, overwrite=True):
        assert (tmp_path / "run" / CLAIM).read_text() != left
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["history.csv"]


def test_without_locks_the_file_is_the_claim_and_is_never_taken_for_dead(tmp_path, monkeypatch):
    def no_locks(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", no_locks)
    with Claim(tmp_path, ALONE, overwrite=False):
        with pytest.raises(SceneError, match=r"without locks; if that run is no more, remove .*/\.claim"):
            Claim(tmp_path, ALONE, overwrite=True).__enter__()
        assert (tmp_path / CLAIM).exists()
    assert not (tmp_path / CLAIM).exists()


def test_of_runs_that_start_at_once_one_runs_and_the_others_are_refused(tmp_path):
    words = [*SLOW_ROLLER, "--set", "solver.max_steps=5"]
    runs = [start(*words, "--out", tmp_path / "run") for _ in range(4)]
    ended = [(process.communicate(), process.returncode) for process in runs]
    assert sorted(code for _, code in ended) == [1, 2, 2, 2]  # 1: max_steps is reached
    for (_, errors), code in ended:
        if code == 2:
            assert errors.count("\n") == 1
            assert "another run writes there" in errors or "holds results already" in errors
    start(*words, "--out", tmp_path / "alone").communicate()
    compare(history(tmp_path / "run"), history(tmp_path / "alone"))
    assert not (tmp_path / "run" / CLAIM).exists()


def test_a_folder_that_a_run_writes_to_is_refused_with_overwrite_and_restart_until_it_is_killed(tmp_path):
    living = start(*SLOW_ROLLER, "--out", tmp_path / "run")
    for line in living.stdout:
        if "Vf max" in line and float(line.split()[0]) >= 1:
            break
    os.kill(living.pid, signal.SIGSTOP)  # so that it does not end meanwhile
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()}
    for words in ([*SLOW_ROLLER, "--out", tmp_path / "run", "--overwrite"], ["--restart", tmp_path / "run"]):
        refused = start(*words)
        errors = refused.communicate()[1]
        assert refused.returncode == 2
        assert f"another run writes there, process {living.pid} on " in errors
    assert {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()} == before
    os.kill(living.pid, signal.SIGKILL)
    living.communicate()
    ended = start("--restart", tmp_path / "run", "--set", "solver.max_steps=9")
    said = ended.communicate()[0]
    assert "going on from" in said
    assert ended.returncode == 1
