"""The numerical error beside that of the inputs: which run is refined, what is read of it, and how it is said."""

import json
from dataclasses import replace

import pytest
from program import DEMOS

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.cli.many_runs import refinement, uncertainty_command
from ncf_fenicsx.sweeps import numerics
from ncf_fenicsx.sweeps.campaign import Campaign
from ncf_fenicsx.sweeps.distributions import Uncertain
from ncf_fenicsx.sweeps.inputs import Column
from ncf_fenicsx.sweeps.numerics import Numerics, NumericsWork, Refinement, in_words, numerics_of
from ncf_fenicsx.sweeps.outcomes import FORCE, VF
from ncf_fenicsx.sweeps.scene_work import SceneWork
from ncf_fenicsx.sweeps.uncertainty import Draw
from ncf_fenicsx.workers import launch
from ncf_fenicsx.workers.cluster import place_for
from ncf_fenicsx.workers.launch import Ended

pytestmark = pytest.mark.serial
FILE = DEMOS / "long_roller.toml"
COLUMNS = (Column("tool.radius", "m"),)


def test_the_middle_is_that_of_each_distribution():
    inputs = [
        Uncertain((Column("a"),), "normal", (3.0, 2.0)),
        Uncertain((Column("b"),), "lognormal", (5.0, 2.0)),
        Uncertain((Column("c"),), "uniform", (0.0, 6.0)),
        Uncertain((Column("d"), Column("e")), "joint", (1.0, 2.0), ((1.0, 0.0), (0.5, 1.0))),
    ]
    middle = Draw.of(inputs, "direct", 20, 1).middle
    assert [float(value) for value in middle] == pytest.approx([3, 5, 3, 1, 2])


@pytest.fixture
def work(tmp_path, monkeypatch):
    """Work whose runs are made up: 1.0 N as the others are, 1.1 N +- 0.03 N by levels."""
    asked = []

    def plain(self, point):  # noqa: ARG001
        asked.append(("plain", point))
        return {"force [N]": "1.0", "vf_max": "0.5", "wrinkle_height [m]": "0", "ending": "done", "reason": ""}

    def levels(file, folder, overrides, limit, ranks, record):  # noqa: ARG001
        asked.append(("levels", overrides, limit, ranks))
        folder.mkdir(parents=True)
        quantities = {"force": {"value": 1.1, "bar": 0.03}, "vf": {"value": 0.52, "bar": None}}
        (folder / record).write_text(json.dumps({"ending": "time is up", "quantities": quantities}), "utf-8")
        return Ended("time is up", "", folder)

    monkeypatch.setattr(SceneWork, "__call__", plain)
    monkeypatch.setattr(launch, "launch", levels)
    made = NumericsWork(SceneWork(FILE, tmp_path, ("stack.layers=2",), COLUMNS, 100.0, 3), ("force", "vf"))
    return made, asked


def test_a_point_is_run_as_the_others_and_by_levels(work):
    made, asked = work
    row = made(("0.002", "5.0"))
    assert asked[0] == ("plain", ("0.002",))
    _, overrides, limit, ranks = asked[1]
    assert (limit, ranks) == (100.0, 3)
    assert {"stack.layers=2", "tool.radius=0.002 m", "accuracy.tolerance=5.0 %"} < set(overrides)
    scene = Scene.read(FILE, overrides)
    assert scene.accuracy.quantities == ("force", "vf")
    assert scene.accuracy.tolerance == pytest.approx(0.05)
    assert scene.accuracy.most_time == pytest.approx(90)
    assert (row["ending"], row["reason"]) == ("done", "time is up")
    assert numerics_of(row) == {FORCE: Numerics(1.0, 1.1, 0.03)}  # without a bar there is no number
    assert numerics_of(row)[FORCE].error == pytest.approx(0.13)


@pytest.mark.parametrize(("height", "more"), [("0", ()), ("0.002", ("wrinkle_height",))])
def test_only_a_run_with_a_wrinkle_has_its_height_refined(work, monkeypatch, height, more):
    made, asked = work
    found = {"force [N]": "1.0", "wrinkle_height [m]": height, "ending": "done", "reason": ""}
    monkeypatch.setattr(SceneWork, "__call__", lambda self, point: found)  # noqa: ARG005
    replace(made, quantities=("force", "wrinkle_height"))(("0.002", "5.0"))
    assert Scene.read(FILE, asked[0][1]).accuracy.quantities == ("force", *more)


def test_a_run_that_fails_is_not_refined(work, monkeypatch):
    made, asked = work
    monkeypatch.setattr(SceneWork, "__call__", lambda self, point: {"ending": "stopped", "reason": "folds"})  # noqa: ARG005
    assert made(("0.002", "5.0")) == {"ending": "stopped", "reason": "folds"}
    assert asked == []
    assert numerics_of(made(("0.002", "5.0"))) == {}


def test_the_error_is_said_beside_the_deviation():
    words = in_words(FORCE, Numerics(1.0, 1.1, 0.03), 0.065)
    assert "largest force on the tool: off by 0.13 N at most" in words
    assert "2 times the standard deviation that the inputs make (0.065 N)" in words
    assert "times" not in in_words(VF, Numerics(0.5, 0.5, 0.01), 0.0)


def test_only_what_a_scene_has_is_asked_for():
    assert refinement(FILE, (), "2 %") == Refinement(0.02, ("force", "vf", "void_volume", "wrinkle_height"))
    assert refinement(DEMOS / "single_element.toml", (), "2 %").quantities == ("force", "vf", "wrinkle_height")


@pytest.mark.parametrize(
    ("accuracy", "expected"),
    [("2", "accuracy.tolerance = '2': expected a positive share"), ("two %", "expected a positive share")],
)
def test_a_wrong_tolerance_is_one_line_and_nothing_is_written(tmp_path, accuracy, expected):
    with pytest.raises(SceneError, match=expected) as caught:
        uncertainty_command(FILE, varied=["tool.radius=uniform(2, 3 mm)"], out=tmp_path / "out", accuracy=accuracy)
    assert "\n" not in str(caught.value)
    assert not any(tmp_path.iterdir())


def test_another_tolerance_is_another_row(tmp_path):
    place = place_for(FILE, (), None, None, 1, 1)
    campaign = Campaign(FILE, (), tmp_path / "study", place, 100.0)
    rows = {"ending": "done", "reason": "ended"}
    handed = []

    def hand_over(plan, given, path, outcomes):  # noqa: ARG001
        (point,) = plan.points()
        handed.append(point)
        heads = [column.heading for column in plan.columns]
        row = dict.fromkeys(outcomes, "") | dict(zip(heads, point, strict=True)) | rows
        path.parent.mkdir(exist_ok=True)
        begun = path.exists()
        with path.open("a", encoding="utf-8") as file:
            file.writelines([*([",".join(row) + "\n"] * (not begun)), ",".join(row.values()) + "\n"])

    object.__setattr__(campaign, "hand_over", hand_over)
    for tolerance in (0.1, 0.05):
        assert numerics.numerics(campaign, COLUMNS, ("0.002",), Refinement(tolerance, ("force",))) == ({}, "ended")
    assert handed == [("0.002", "10.0"), ("0.002", "5.0")]
