"""Runs on local workers and on a scheduler that stands: each has its row once, whoever dies on the way."""

import os
import re
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import chain

import pytest
import stand_in_runs
from program import ROOT

from ncf_fenicsx import SceneError
from ncf_fenicsx.workers.cluster import Place, batch_cluster
from ncf_fenicsx.workers.engine import results
from ncf_fenicsx.workers.rows import read_rows

pytestmark = pytest.mark.serial


def points(count):
    return [(repr(float(number)),) for number in range(count)]


def plain_loop(count):
    return {point: stand_in_runs.trivial(point) for point in points(count)}


def test_local_workers_do_what_a_plain_loop_does():
    with Place(workers=2).opened() as connection:
        assert connection.at_a_time == 2
        found = list(results(connection, stand_in_runs.trivial, iter(points(20))))
    assert len(found) == 20
    assert dict(found) == plain_loop(20)


def test_a_run_whose_worker_dies_is_tried_once_again(tmp_path, monkeypatch):
    monkeypatch.setenv("MARKS", str(tmp_path))
    with Place(workers=1).opened() as connection:
        found = dict(results(connection, stand_in_runs.deadly, points(4)))
    assert found["1.0",] == {"ending": "error", "reason": "its worker has died at each try"}
    assert [found[point]["ending"] for point in points(4)] == ["done", "error", "done", "done"]


def test_an_error_of_a_run_is_its_reason():
    with Place(workers=1).opened() as connection:
        found = dict(results(connection, stand_in_runs.wrong, points(1)))
    assert found["0.0",] == {"ending": "error", "reason": "ValueError: no run of 0.0"}


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextmanager
def processes():
    """Starts programs of Dask; ends those that are left."""
    started = []
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}

    def start(*words):
        command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
        process = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        started.append(process)
        return process

    try:
        yield start
    finally:
        for process in started:
            process.kill()
            process.wait()


def test_a_killed_worker_and_a_scheduler_that_starts_again_cost_no_row(tmp_path, monkeypatch):
    monkeypatch.setenv("MARKS", str(tmp_path))
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    scheduler = "dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"
    worker = "dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "60"
    with processes() as start:
        first = start(*scheduler)
        time.sleep(2)
        workers = [start(*worker), start(*worker)]
        with Place(scheduler=address).opened() as connection:
            runs = results(connection, stand_in_runs.noted, iter(points(40)))
            found = [next(runs) for _ in range(10)]
            workers[0].kill()
            found += [next(runs) for _ in range(8)]
            first.kill()
            first.wait()
            start(*scheduler)
            for one in (start(*worker), start(*worker)):
                assert one.poll() is None
            found = list(chain(found, runs))
    assert len(found) == 40
    assert dict(found) == plain_loop(40)
    begun = [len((tmp_path / f"{point[0]}.txt").read_text().splitlines()) for point in points(40)]
    assert sum(begun) <= 44  # again only what was on its way: one of the worker, two of the scheduler, one to spare


RUN_ALL = """
import sys
from pathlib import Path
import stand_in_runs
from ncf_fenicsx.workers.engine import run_missing
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.sweeps.inputs import Column
from ncf_fenicsx.sweeps.plans import Plan

OUTCOMES = ["y", "ending", "reason"]

if __name__ == "__main__":
    plan = Plan((Column("a"),), 30, lambda: iter([(repr(float(number)),) for number in range(30)]))
    with Place(workers=2).opened() as connection:
        run_missing(plan.points(), plan.headings, OUTCOMES, stand_in_runs.noted, connection, Path(sys.argv[1]))
"""


def test_a_study_that_is_killed_keeps_its_rows_and_runs_none_of_them_again(tmp_path):
    script, table = tmp_path / "all.py", tmp_path / "rows.csv"
    script.write_text(RUN_ALL)
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    environment = os.environ | {"PYTHONPATH": path, "MARKS": str(tmp_path)}
    command = [sys.executable, str(script), str(table)]
    first = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    while not table.exists() or len(table.read_bytes().splitlines()) < 9:
        assert first.poll() is None
        time.sleep(0.05)
    first.kill()
    first.wait()
    kept = {line.split(",")[0] for line in table.read_text().splitlines(keepends=True)[1:] if line.endswith("\n")}
    marks = {point: (tmp_path / f"{point}.txt").read_text() for point in kept}
    subprocess.run(command, env=environment, check=True, capture_output=True)
    found = [tuple(row.values()) for row in read_rows(table)]
    assert sorted(found) == sorted((point[0], *outcome.values()) for point, outcome in plain_loop(30).items())
    assert {point: (tmp_path / f"{point}.txt").read_text() for point in kept} == marks


def test_no_place_but_one(monkeypatch):
    with pytest.raises(SceneError, match="expected one of slurm, pbs, lsf"):
        Place(batch_system="moab")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(SceneError, match="no sbatch here; expected a machine that submits jobs"):
        Place(batch_system="slurm")
    with pytest.raises(SceneError, match="expected one of them"):
        Place(scheduler="tcp://a:1", batch_system="slurm")


def test_as_many_runs_at_a_time_as_cores_and_memory_allow():
    assert Place(ranks=10**6).at_a_time == 1
    assert Place(memory=1e9).at_a_time == 1
    assert Place(memory=1e-6).at_a_time == len(os.sched_getaffinity(0))


@pytest.mark.parametrize("name", ["slurm", "pbs", "lsf"])
def test_a_job_asks_for_the_cores_and_the_memory_of_one_run(name):
    with batch_cluster(name, ranks=4, memory=3.0) as cluster:
        script = cluster.job_script()
    wanted = {"slurm": r"--cpus-per-task=4", "pbs": r"ncpus=4:mem=2", "lsf": r"-n 4"}
    assert re.search(wanted[name], script)
    assert script.rindex("--nthreads 1") > script.index("--nthreads 4") if "--nthreads 4" in script else True
