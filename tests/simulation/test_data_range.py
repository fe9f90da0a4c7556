"""A run that leaves the data of a law says so when it happens, and how far it went."""

import json

import pytest

from ncf_fenicsx import Scene, run

pytestmark = pytest.mark.two_ranks

TABLE = {
    "stack": {"layers": 1, "size": ["6 mm", "4 mm"], "divisions": [2, 1], "grading": [0, 0]},
    "laws": {
        "rate": {"kind": "none"},
        "compaction": {"kind": "table", "volume_fraction": [0.38, 0.40, 0.45], "stress": ["-1 kPa", "0 kPa", "3 kPa"]},
    },
    "output": {"picture": False, "report": False, "fields_every": 1000},
}


@pytest.mark.parametrize(("depth", "left"), [(0.1, False), (0.4, True)])
def test_a_table_that_ends_is_a_caution_with_how_far_it_was_left(folder, capsys, depth, left):
    path = [{"travel": ["0 mm", "0 mm", f"-{depth} mm"], "speed": "1 mm/min"}]
    result = run(Scene.from_table(TABLE | {"tool": {"kind": "plate", "path": path}}), folder)
    assert result.done, result.reason
    record = json.loads((folder / "run.json").read_text("utf-8"))
    assert ("beyond_data" in record) == left
    if left:
        found = record["beyond_data"]["laws.compaction"]
        first = next(row for row in result.history if row["vf_max"] > 0.45)
        assert found["time"] == first["time"]
        assert found["limit"] == 0.45
        assert found["volume_fraction"] == pytest.approx(max(row["vf_max"] for row in result.history))
    said = capsys.readouterr().out
    assert ("beyond the data, which end at 0.45" in said) == (left and "step" in said)
