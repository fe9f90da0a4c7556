"""A sweep through the command line: rows, resumed, failures with their reasons, and mistakes that write nothing."""

import csv
import json
from pathlib import Path

import pytest
from program import DEMOS, call

from ncf_fenicsx import SceneError
from ncf_fenicsx.cli.many_runs import sweep_command
from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.sweeps.inputs import Column
from ncf_fenicsx.sweeps.scene_work import SceneWork

pytestmark = pytest.mark.serial
FILE = DEMOS / "long_roller.toml"
SMALL = ("stack.layers=1", "stack.divisions=[4, 1]", "tool.path.0.travel=['0 mm', '0 mm', '-0.05 mm']")
COARSE = [word for text in SMALL for word in ("--set", text)]


def rows(folder):
    with (folder / "rows.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_is_resumed_and_keeps_what_failed(tmp_path):
    out = tmp_path / "out"
    words = ["study", "sweep", FILE, *COARSE, "--workers", 1, "--out", out]
    words += ["--vary", "tool.path.0.speed=1,10 mm/min"]
    first = call(*words)
    assert first.returncode == 0, first.stderr
    assert "2 runs: 2 done" in first.stdout
    assert "of the variance of the largest force on the tool carries tool.path.0.speed 100 %" in first.stdout
    one, two = rows(out)
    assert one["ending"] == "done"
    history = read_history(out / "runs" / one["run"] / "history.csv")
    assert float(one["force [N]"]) == pytest.approx(history["tool_force"].max())
    speeds = sorted(float(row["tool.path.0.speed [m/s]"]) for row in (one, two))
    assert speeds == pytest.approx([1e-3 / 60, 1e-2 / 60])
    for name in ("rows.parquet", "effects.png", "parallel.png", "report.html", "scene.toml"):
        assert (out / name).stat().st_size > 500
    again = {"out": out, "varied": ["tool.path.0.speed=1,10,20 mm/min"], "workers": 1}
    with pytest.raises(SceneError, match="has runs of another scene"):
        sweep_command(FILE, overrides=[*SMALL, "solver.max_steps=40"], **again)
    (out / "rows.csv").write_text((out / "rows.csv").read_text() + "0.5,half a row")
    sweep_command(FILE, overrides=list(SMALL), **again)
    assert [row["run"] for row in rows(out)][:2] == [one["run"], two["run"]]  # not run again
    assert len(rows(out)) == 3


def test_a_run_that_stops_or_fails_has_its_reason_and_no_numbers(tmp_path):
    columns = (Column("solver.max_steps", whole=True),)
    work = SceneWork(FILE, tmp_path, SMALL, columns, 300.0)
    stopped = work(("2",))
    assert (stopped["ending"], stopped["reason"]) == ("stopped", "max_steps = 2 reached")
    assert stopped["force [N]"] == ""
    assert stopped["run"] == next(tmp_path.iterdir()).name
    assert work(("2",)) == stopped  # from what it has left
    failed = work(("-1",))
    assert failed["ending"] == "error"
    assert "max_steps" in failed["reason"]
    assert json.loads((tmp_path / failed["run"] / "outcome.json").read_text()) == failed


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({"varied": ["stack.layrs=1,2"]}, "layrs"),
        ({"varied": ["tool.radius=1,2 MPa"]}, "expected a positive length"),
        ({"varied": ["tool.radius=1,2 mm"], "cluster": "none"}, "expected one of slurm, pbs, lsf"),
        ({"listed": Path("none.csv")}, "No such file"),
        ({}, "expected either --vary"),
        ({"varied": ["tool.radius=1,2 mm"], "plan": "random"}, "expected either --vary"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(tmp_path, words, expected):
    with pytest.raises(SceneError, match=expected) as caught:
        sweep_command(FILE, out=tmp_path / "out", **words)
    assert "\n" not in str(caught.value)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "more", "expected"),
    [
        ("tool.radius=5..2 mm:3", [], "empty range"),
        ("tool.radius=1,2 mm", ["--scheduler", "tcp://127.0.0.1:1"], "does not answer"),
    ],
)
def test_the_program_says_so_with_exit_code_2(tmp_path, text, more, expected):
    ended = call("study", "sweep", FILE, "--vary", text, *more, "--out", tmp_path / "out")
    assert ended.returncode == 2
    assert expected in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1
    assert not any(tmp_path.iterdir())
