"""What cannot be drawn at the end of a run is a line: no result is lost, and the run ends as it did."""

import json
import re
import subprocess
import sys

import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.accuracy.command import Order, carry_out
from ncf_fenicsx.report import closing, summary_picture
from ncf_fenicsx.report.closing import LONGEST, drawn_or_told
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.summary_picture import draw_summary

pytestmark = pytest.mark.serial


def fails(_):
    raise RuntimeError("nothing is\ndrawn today")


def test_each_file_is_made_whatever_becomes_of_the_others(tmp_path):
    made = []
    told = drawn_or_told(tmp_path, {"first.png": fails, "second.png": made.append})
    assert told == ["no first.png: RuntimeError: nothing is drawn today; the results are complete without it"]
    assert made == [tmp_path]


def test_a_long_message_is_cut(tmp_path):
    (words,) = drawn_or_told(tmp_path, {"first.png": lambda _: int("word" * 1000)})
    assert len(words) < LONGEST + 80


@pytest.mark.parametrize(("steps", "code"), [(None, 0), (2, 1)])
def test_a_run_that_cannot_be_drawn_ends_as_it_did(tmp_path, monkeypatch, table, capfd, steps, code):
    monkeypatch.setattr(summary_picture, "draw_summary", fails)
    monkeypatch.setattr(closing, "write_report", fails)
    changes = {"output": {}} if steps is None else {"output": {}, "solver": {"max_steps": steps}}
    (tmp_path / "scene.toml").write_text(Scene.from_table(table | changes).to_toml(), encoding="utf-8")
    order = Order(tmp_path / "scene.toml", tmp_path / "run", (), False, None, {}, False, 1)
    assert carry_out(order) == code
    told = capfd.readouterr()
    for name in ("summary.png", "report.html"):
        assert len(re.findall(rf"^caution: no {name}: RuntimeError: nothing is drawn today; .*$", told.out, re.M)) == 1
        assert not (tmp_path / "run" / name).exists()
    assert "Traceback" not in told.out + told.err
    results = Results.read(tmp_path / "run")
    assert results.rows > 1
    assert results.record["ending"] == json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))["ending"]
    assert results.record["time"] == results.history["time"][-1]


def test_fields_that_cannot_be_read_cost_the_picture_alone(copied):
    last = max((copied / "fields").glob("*.vtu"))
    last.write_bytes(last.read_bytes()[:100])
    kept = (copied / "summary.png").read_bytes()
    (words,) = drawn_or_told(copied, {"summary.png": draw_summary})
    assert words.startswith("no summary.png: ")
    assert (copied / "summary.png").read_bytes() == kept


def test_a_run_without_pictures_or_waves_loads_nothing_that_draws_or_searches_for_them(tmp_path, table):
    scene = Scene.from_table(table | {"solver": {"max_steps": 1}, "output": {"picture": False, "report": False}})
    (tmp_path / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    program = (
        "import sys; from ncf_fenicsx import cli\n"
        "try: cli.main()\n"
        "finally: print('loaded', [name for name in ('matplotlib', 'scipy.signal', 'dask') if name in sys.modules])"
    )
    for more, loaded in (([], []), (["--set", "output.picture=true"], ["matplotlib"])):
        command = ["run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "run"), "--ranks", "1", "--overwrite"]
        ended = subprocess.run(
            [sys.executable, "-c", program, *command, *more], capture_output=True, text=True, check=False
        )
        assert f"loaded {loaded}" in ended.stdout, ended.stderr
