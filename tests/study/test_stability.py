"""The stability study: its grid is of valid scenes, its runs are resumed, its map and words follow its rows."""

import csv
import subprocess
import sys
import time
from contextlib import suppress

import pytest
from mpi4py import MPI
from program import DEMOS

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.output.claim import Claim
from ncf_fenicsx.study.stability import study_stability, summary
from ncf_fenicsx.study.stability_grid import Case, stability_grid
from ncf_fenicsx.study.stability_map import COLOURS, draw_map, verdict
from ncf_fenicsx.study.stability_runner import COLUMNS, Runner
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.rows import read_rows

pytestmark = pytest.mark.serial
FILE = DEMOS / "long_roller.toml"
SMALL = ("stack.layers=2", "stack.divisions=[6, 1]", "tool.path.0.travel=['0 mm', '0 mm', '-0.1 mm']")


def test_every_case_of_the_grid_is_a_valid_scene_with_a_name_of_its_own():
    cases = stability_grid(Scene.read(FILE))
    assert len({case.name for case in cases}) == len(cases) > 60
    same = Scene.read(FILE).table()
    changed = [case for case in cases if Scene.read(FILE, case.overrides).table() != same]
    assert len(changed) >= len(cases) - 5  # a value of five axes is the scene's own
    moduli = [
        Scene.read(FILE, case.overrides).laws.in_plane.modulus for case in cases if case.axis.startswith("in-plane")
    ]
    assert min(moduli) == 1e6
    assert max(moduli) == 1e12


def runner(folder, **changes):
    values = {
        "scene": FILE,
        "folder": folder,
        "overrides": SMALL,
        "refinement": 2,
        "limit": 200,
        "place": Place(workers=2),
    }
    return Runner(**values | changes)


def test_a_study_runs_what_is_missing_and_draws_its_map(tmp_path):
    scene = Scene.read(FILE, SMALL)
    words = study_stability(scene, runner(tmp_path), ["layers"])
    rows = list(read_rows(runner(tmp_path).table))
    assert [row["ending"] for row in rows] == ["done"] * 3
    assert "3 of 3 runs with sound laws done" in words
    assert (tmp_path / "stability.png").stat().st_size > 1e4
    assert all(abs(float(row["difference"])) < 0.01 for row in rows)
    forces = {row["value"]: float(row["force_N"]) for row in rows}
    assert forces["bonded"] > forces["one_sided"]
    with (tmp_path / "stability.csv").open("w", newline="") as file:  # as if the study had been ended on its way
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerow(rows[0] | {"force_N": "1"})
    study_stability(scene, runner(tmp_path), ["layers"])
    again = list(read_rows(runner(tmp_path).table))
    assert len(again) == 3
    assert again[0]["force_N"] == "1"  # not run again


def test_a_run_that_stops_fails_or_takes_too_long_is_a_row_with_its_reason(tmp_path):
    stops = Case("made up", "stops", ("solver.max_steps=2",))
    wrong = Case("made up", "wrong", ("stack.layers=-1",))
    slow = Case("made up", "slow", ())
    rows = {row["value"]: row for row in runner(tmp_path).run([stops, wrong])}
    assert rows["stops"]["ending"] == "stopped"
    assert rows["stops"]["reason"] == "max_steps = 2 reached"
    assert rows["stops"]["reference_force_N"] == ""
    assert rows["wrong"]["ending"] == "error"
    assert "stack.layers = -1" in rows["wrong"]["reason"]
    (found,) = runner(tmp_path / "short", limit=0.5).run([slow])
    assert found["ending"] == "time limit"


def row(**changes):
    return dict.fromkeys(COLUMNS, "") | {"axis": "a", "value": "1", "sound": "true", "ending": "done"} | changes


def test_verdicts_and_words():
    rows = [
        row(difference="0.001"),
        row(value="2", difference="-0.02"),
        row(value="3", stability_lost_s="4.5"),
        row(value="4", ending="stopped"),
        row(value="5", ending="error"),
        row(value="6", ending="stopped", sound="false"),
    ]
    assert [verdict(one) for one in rows[:5]] == [list(COLOURS)[number] for number in (0, 2, 1, 3, 4)]
    words = summary(rows)
    assert "3 of 5 runs with sound laws done, 1 stopped with a reason, 1 neither" in words
    assert "1 of 2 forces within 1 %" in words
    assert "worst 2 %" in words


def test_the_map_is_drawn(tmp_path):
    draw_map([row(), row(value="2", ending="stopped", iterations="12", cuts="3")], "title", tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 5e3


def test_a_study_needs_a_tool_that_goes_down_and_known_axes(tmp_path):
    with pytest.raises(SceneError, match="expected a scene with one tool"):
        study_stability(Scene.from_table({"duration": "1 s"}), runner(tmp_path))
    with pytest.raises(SceneError, match="--axis none: no such axis; expected the beginning of one of: in-plane"):
        study_stability(Scene.read(FILE), runner(tmp_path), ["none"])


def test_a_run_ends_with_the_process_that_started_it(tmp_path):
    words = "from ncf_fenicsx.workers.launch import launch; from pathlib import Path; import sys; "
    words += "launch(Path(sys.argv[1]), Path(sys.argv[2]), (), 600.0)"
    study = subprocess.Popen([sys.executable, "-c", words, str(DEMOS / "roller.toml"), str(tmp_path / "run")])
    while not (tmp_path / "run" / "history.csv").exists():
        assert study.poll() is None
        time.sleep(0.1)
    study.kill()
    study.wait()
    for _ in range(100):
        with suppress(SceneError), Claim(tmp_path / "run", MPI.COMM_SELF, overwrite=True):
            return  # it is refused while a run writes there
        time.sleep(0.1)
    pytest.fail("the run goes on")
