"""What a run costs, in units of one factorisation: every figure is there, and nothing is left behind."""

import re
import tempfile
from pathlib import Path

import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene
from ncf_fenicsx.study.run_cost import benchmark_run

pytestmark = pytest.mark.two_ranks


def test_a_run_is_weighed(table, monkeypatch, folder):
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    words = benchmark_run(Scene.from_table(table))
    found = dict(re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", words, re.MULTILINE))
    assert found["ending"].startswith("done at 12 s")
    assert found["unknowns, ranks"] == f"252, {MPI.COMM_WORLD.size}"
    seconds, ratio = map(float, found["run, over both"].replace(" s", "").split(", "))
    assert seconds > 0
    assert ratio > 1
    assert float(found["of it assembly"].rstrip(" %")) > 0
    for piece in ("tangent", "residual", "factors", "solution with factors", "pairing of layers"):
        assert float(found[f"one {piece}"].removesuffix(" ms")) > 0
    MPI.COMM_WORLD.barrier()
    assert not [path for path in Path(folder).iterdir() if path.is_dir()]
