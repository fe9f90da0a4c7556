"""What random scenes share: values over decades, and what must be true of each run, however it ends."""

import json
import math
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase
from hypothesis import strategies as st

from ncf_fenicsx import Scene, run
from ncf_fenicsx.output.checkpoint import NAME


def decades(low, high, unit):
    """Values spread evenly over decades, as text with a unit."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda power: f"{10**power:.4g} {unit}".strip())


def check(table):
    """Run a scene and judge what it says; whether it ended."""
    scene = Scene.from_table(table)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        result = run(scene, folder / "run")
        record = json.loads((folder / "run" / "run.json").read_text())
        assert (record["ending"] == "done") == result.done
        assert result.done or len(record["reason"]) > 20, record["reason"]
        if not result.history:
            assert "come to rest" in result.reason
            return False
        assert (folder / "run" / NAME).is_file()
    for row in result.history:
        assert all(math.isfinite(value) for value in row.values())
        assert 0 < row["vf_min"] <= row["vf_max"] < 1
        carried = row["support_force"] - row["weight"]
        viscous = row["viscous_force"]  # a bound on what it carries
        assert carried == pytest.approx(row["tool_force"], rel=1e-5, abs=1e-5 * row["weight"] + viscous)
        assert row["tool_force"] > -1e-9 * row["weight"]
    if result.done:
        assert result.history[-1]["time"] == scene.milestones[-1]
    return result.done


PROFILE = {
    "deadline": None,
    "derandomize": True,
    "suppress_health_check": list(HealthCheck),
    "phases": (Phase.generate,),
}
