"""Nothing is lost when a run is killed at random moments or ended by a signal."""

import os
import random
import signal
import subprocess
import time

import pytest
from runs_apart import SLOW_ROLLER, compare, history, start


def ranks_of(process):
    """Process numbers of the Python programs that a run consists of."""
    listed = subprocess.run(["ps", "-eo", "pid,pgid,sid,comm"], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in listed.splitlines()[1:]]
    return [int(row[0]) for row in rows if int(row[2]) == process.pid and row[3].startswith("python")]


def rows(out):
    """Rows of a history so far."""
    return len(history(out)) if (out / "history.csv").exists() else 0


def kill_at(process, out, row, seconds, one_rank):
    """Kill all of a run, or one of its ranks, some seconds after its history has so many rows."""
    while process.poll() is None and rows(out) < row:
        time.sleep(0.02)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        if one_rank:
            os.kill(ranks_of(process)[-1], signal.SIGKILL)
        else:
            os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


@pytest.mark.serial
@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.slow)])
def test_killed_at_random_moments_a_run_ends_with_the_same_history(tmp_path, kills):
    out, moments = tmp_path / "killed", random.Random(4)
    whole = start(*SLOW_ROLLER, "--out", tmp_path / "whole")
    assert whole.wait() == 0
    reached = 0
    for number in range(kills):
        arguments = ["--restart", out] if (out / "scene.toml").exists() else [*SLOW_ROLLER, "--out", out]
        ranks = 1 + number % 2
        kill_at(start(*arguments, ranks=ranks), out, reached + 1, moments.uniform(0.0, 0.3), one_rank=ranks == 2)
        reached = rows(out)
    ended = start("--restart", out)
    ended.communicate()
    assert ended.returncode == 0
    assert 0 < reached < rows(out)  # it was killed on the way, not before or after
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
