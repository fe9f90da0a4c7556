"""Ranks that are chosen, and runs that are started on them."""

import json
import os
import signal

import pytest
from program import DEMOS, call
from runs_apart import SLOW_ROLLER, history, start

from ncf_fenicsx.simulation import ranks
from ncf_fenicsx.simulation.ranks import free_memory, physical_cores, ranks_that_pay

pytestmark = pytest.mark.serial


def test_small_runs_stay_alone_and_large_ones_take_the_cores_that_pay(monkeypatch):
    for name in ranks.LAUNCHERS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(ranks, "physical_cores", lambda: 16)
    monkeypatch.setattr(ranks, "free_memory", lambda: 64e9)
    monkeypatch.setattr(ranks, "idle_cores", lambda: 16)
    assert ranks_that_pay(3720, 2e8) == 1
    assert 1 < ranks_that_pay(24_600, 4e8) <= 3
    assert ranks_that_pay(657_360, 5e9) == 16
    monkeypatch.setattr(ranks, "free_memory", lambda: 5.5e9)
    assert ranks_that_pay(657_360, 5e9) == 3  # each one takes memory for the program
    monkeypatch.setattr(ranks, "idle_cores", lambda: 2)
    assert ranks_that_pay(657_360, 5e9) == 2  # what others work on is theirs
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    assert ranks_that_pay(657_360, 5e9) == 1  # a launcher has decided


def test_a_second_thread_is_no_core_and_a_quota_counts(monkeypatch):
    lines = [
        f"{key}\t: {value}"
        for n in range(4)
        for key, value in (("processor", n), ("physical id", 0), ("core id", n // 2))
    ]
    monkeypatch.setattr(ranks, "processor_lines", lambda: lines)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3})
    monkeypatch.setattr(ranks, "_quota", lambda: 8)
    assert physical_cores() == 2
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    assert physical_cores() == 1
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 2})
    monkeypatch.setattr(ranks, "_quota", lambda: 1)
    assert physical_cores() == 1


def test_processors_that_work_are_not_idle(monkeypatch):
    before = "cpu 9 9\ncpu0 0 0 0 0 0 0 0 0 0 0\ncpu1 5 0 0 7 0 0 0 0 0 0\nintr 1\n"
    after = "cpu 9 9\ncpu0 0 0 1 22 2 0 0 0 0 0\ncpu1 25 0 5 8 0 0 0 0 0 0\nintr 1\n"
    looks = iter([before, after])
    monkeypatch.setattr(ranks, "_text", lambda _: next(looks))
    assert ranks.idle_cores() == 1


def test_memory_is_that_of_the_machine_within_the_limit_of_a_container(monkeypatch):
    files = {
        "/proc/meminfo": "MemTotal: 9000 kB\nMemAvailable: 8000 kB\n",
        "/sys/fs/cgroup/memory.max": "3000000\n",
        "/sys/fs/cgroup/memory.current": "1000000\n",
    }
    monkeypatch.setattr(ranks, "_text", lambda path: files.get(path, ""))
    assert free_memory() == 2e6
    files["/sys/fs/cgroup/memory.max"] = "max\n"
    assert free_memory() == 8000 * 1024


SMALL = [DEMOS / "long_roller.toml", "--set", "stack.divisions=[8, 2]", "--set", "output.picture=false"]
SMALL += ["--set", "output.report=false"]


def test_a_run_is_started_on_the_ranks_asked_for_and_has_its_exit_code(tmp_path):
    done = call("run", *SMALL, "--ranks", 2, "--out", tmp_path / "done")
    assert done.returncode == 0, done.stderr
    assert "done: end of the path reached" in done.stdout
    assert json.loads((tmp_path / "done" / "run.json").read_text("utf-8"))["ranks"] == 2


def test_wrong_input_is_refused_before_ranks_are_started(tmp_path):
    for words, expected in (
        (["--set", "tool.position=['1 m', '0 m']"], "tool"),
        (["--out", tmp_path], "holds results already"),
    ):
        (tmp_path / "something").touch()
        out = [] if "--out" in words else ["--out", tmp_path / "new"]
        ended = call("run", *SMALL, *words, *out, "--ranks", 2)
        assert ended.returncode == 2
        assert expected in ended.stderr
        assert ended.stderr.count("\n") == 1  # nothing of a launcher in it
        assert not (tmp_path / "new").exists()


def test_a_launcher_and_ranks_that_disagree_are_refused(tmp_path):
    ended = call("run", *SMALL, "--ranks", 3, "--out", tmp_path / "run", ranks=2)
    assert ended.returncode == 2
    assert "--ranks 3: mpirun has started 2; expected only one of both" in ended.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_a_signal_to_the_program_saves_the_state_of_its_ranks(tmp_path, number):
    process = start(*SLOW_ROLLER, "--set", "output.checkpoint_every=1000", "--out", tmp_path / "run", "--ranks", "2")
    for line in process.stdout:
        if "Vf max" in line and float(line.split()[0]) >= 2:
            break
    os.kill(process.pid, number)
    said, errors = process.communicate()
    assert process.returncode == 1
    assert f"stopped: interrupted by {number.name}" in said
    assert "Traceback" not in errors
    assert 1.9 < history(tmp_path / "run")[-1]["time"] < 30
    assert (tmp_path / "run" / "checkpoint.h5").is_file()
