"""What all tests share: ranks that meet after every test, and one temporary folder for all of them."""

import gc
import sys
from pathlib import Path

import pytest
from mpi4py import MPI

COMM = MPI.COMM_WORLD


def pytest_collection_modifyitems(items):
    """Leave out tests for fewer ranks than there are."""
    for mark, most in (("serial", 1), ("two_ranks", 2)):
        for item in items:
            if most < COMM.size and item.get_closest_marker(mark):
                item.add_marker(pytest.mark.skip(reason=f"for {most} at most"))


def pytest_collection_finish():
    """What is imported by now stays; to look through it after each test took longer than most tests."""
    gc.collect()
    gc.freeze()


def pytest_xdist_auto_num_workers():
    """Tests on several ranks keep all cores busy as it is; else a process for each core."""
    return 0 if COMM.size > 1 else None


@pytest.hookimpl(trylast=True)
def pytest_configure(config):
    """One report for all ranks, from rank 0."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if COMM.rank and reporter is not None:
        config.pluginmanager.unregister(reporter)


def pytest_runtest_logreport(report):
    """What fails on another rank alone is shown too."""
    if COMM.rank and report.failed:
        print(f"rank {COMM.rank}: {report.nodeid}\n{report.longreprtext}", file=sys.stderr, flush=True)


@pytest.fixture(autouse=True)
def _ranks_meet():
    yield
    gc.collect()
    COMM.barrier()


@pytest.fixture
def folder(tmp_path) -> Path:
    """A temporary folder, the same on all ranks."""
    return COMM.bcast(tmp_path)


@pytest.fixture
def table():
    """A small scene as a table: two layers of 6 x 2 elements under a long roller."""
    return {
        "stack": {
            "layers": 2,
            "size": ["12 mm", "6 mm"],
            "divisions": [6, 2],
            "grading": [0.0, 0.0],
        },
        "interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0},
        "tool": {"width": "infinite", "path": [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]},
        "output": {"picture": False, "report": False},
    }
