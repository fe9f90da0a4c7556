"""Sequences of runs to an accuracy: what they come to, that they go on, what ends them, what they refuse."""

import json
import signal
import time
import tomllib
from pathlib import Path

import pytest
from mpi4py import MPI
from program import DEMOS, call
from runs_apart import start

import ncf_fenicsx
from ncf_fenicsx import Scene, SceneError, simulation
from ncf_fenicsx.accuracy import sequence
from ncf_fenicsx.accuracy.answer import Answer, Level
from ncf_fenicsx.accuracy.cost import Cost
from ncf_fenicsx.accuracy.sequence import plan, run
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.simulation.run_record import Result

pytestmark = pytest.mark.two_ranks

ONE = DEMOS / "single_element.toml"
QUIET = ["output.picture=false", "output.report=false"]
SMALL = [
    "stack.layers=2",
    "stack.size=['12 mm', '6 mm']",
    "stack.divisions=[12, 1]",
    "stack.grading=[0, 0]",
    "stack.sides.y_max=symmetry",
    "laws.shear.modulus=2 MPa",
    "tool.path.0.travel=['0 mm', '0 mm', '-0.2 mm']",
    *QUIET,
]


def answer_in(folder):
    return json.loads((folder / "accuracy.json").read_text("utf-8"))


def pressed(scene):
    """Force in N on a plate that has pressed one hexahedron, and the Vf in it, by the law itself."""
    initial, thickness = scene.stack.initial_volume_fraction, scene.stack.thickness
    vf = initial / (1 + scene.segments[0].travel[2] / thickness)
    area = scene.stack.size[0] * scene.stack.size[1] * scene.stack.sides.copies
    factor = scene.laws.rate.factor(scene.segments[0].speed)
    return float(area * factor * scene.laws.compaction.pressure(vf, initial)), vf


def test_the_closed_form_of_a_pressed_element_is_inside_the_bars(folder, capsys):
    """What its penalty lets through is all that is wrong: a tenth of the force in the coarsest level."""
    changes = ["accuracy.tolerance=0.1 %", "accuracy.quantities=['force', 'vf', 'vf_field']"]
    scene = Scene.read(ONE, changes)
    result = ncf_fenicsx.run(scene, folder / "run")
    assert result.done, result.reason
    force, vf = pressed(scene)
    found = answer_in(folder / "run")
    assert found["met"]
    assert found["levels"][0]["values"]["force"] == pytest.approx(force, rel=0.2)
    for name, true in (("force", force), ("vf", vf)):
        one = found["quantities"][name]
        assert abs(one["value"] - true) <= one["bar"] <= 2 * abs(one["value"] - true), name
        assert one["relative_bar"] <= 0.001
        assert one["limit"] == pytest.approx(true, rel=2e-3)
    change = abs(vf - scene.stack.initial_volume_fraction)
    field = found["quantities"]["vf_field"]
    assert abs(field["value"] - change) <= field["bar"]
    assert result.history[-1]["tool_force"] == found["quantities"]["force"]["value"]
    if MPI.COMM_WORLD.rank == 0:
        _shown_everywhere(result.folder, found, capsys.readouterr().out)


def _shown_everywhere(finest, found, said):
    """Progress lines, the record of the finest run, its page and its picture have the bars."""
    words = found["quantities"]["force"]["bar_words"]
    assert words in said
    assert any(" N +- " in line and "Vf max" in line for line in said.splitlines())
    assert json.loads((finest / "run.json").read_text("utf-8"))["accuracy"]["quantities"] == found["quantities"]
    results = Results.read(finest)
    last = results.errors["tool_force_error"][-1], results.errors["vf_max_error"][-1]
    assert last == pytest.approx([found["quantities"][name]["bar"] for name in ("force", "vf")])
    assert words.split(",")[0] in (finest / "report.html").read_text("utf-8")
    assert (finest / "summary.png").is_file()
    assert words in (finest.parent / "report.html").read_text("utf-8")


def test_a_plan_tells_what_levels_cost_before_anything_runs():
    words = "\n".join(plan(Scene.read(DEMOS / "roller.toml", ["accuracy.tolerance=2 %"])))
    assert words.startswith("accuracy: force to 2 %, by levels")
    assert "level 0: 10 x 6 elements a layer" in words
    assert "level 2: 40 x 24 elements a layer, steps x 1: about 24,600 unknowns" in words


@pytest.mark.serial
def test_killed_in_a_level_a_sequence_goes_on_and_may_ask_for_more(tmp_path):
    words = [DEMOS / "long_roller.toml", *(word for text in SMALL for word in ("--set", text))]
    words += ["--accuracy", "20 %", "--set", "output.checkpoint_every=1"]
    changes = [*SMALL, "accuracy.tolerance=20 %"]
    assert run(Scene.read(DEMOS / "long_roller.toml", changes), tmp_path / "whole").done
    killed = start(*words, "--out", tmp_path / "killed")
    for line in killed.stdout:
        if line.startswith("level 1:"):
            break
    killed.stdout.readline()
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert len(answer_in(tmp_path / "killed")["levels"]) == 1
    before = (tmp_path / "killed" / "level_0" / "run.json").stat().st_mtime_ns
    scene = Scene.read(tmp_path / "killed" / "scene.toml")
    assert run(scene, tmp_path / "killed", restart=True).done
    assert (tmp_path / "killed" / "level_0" / "run.json").stat().st_mtime_ns == before  # not run again
    values = [answer_in(tmp_path / name)["quantities"]["force"] for name in ("whole", "killed")]
    assert values[0]["value"] == pytest.approx(values[1]["value"], rel=1e-9)
    assert values[0]["bar"] == pytest.approx(values[1]["bar"], rel=1e-6)
    _goes_on_only_as_itself(tmp_path / "killed", len(answer_in(tmp_path / "killed")["levels"]))


def _goes_on_only_as_itself(folder, levels):
    """Another tolerance may be asked for; another law may not."""
    file = folder / "scene.toml"
    with pytest.raises(SceneError, match=r"laws: expected it as it was: only \[accuracy\] may change"):
        run(Scene.read(file, ["laws.shear.modulus=3 MPa"]), folder, restart=True)
    more = Scene.read(file, ["accuracy.tolerance=0.001 %", "accuracy.most_memory=0.1 GB"])
    assert not run(more, folder, restart=True).done
    found = answer_in(folder)
    assert len(found["levels"]) == levels  # as none may be run, those that there are
    assert "most_memory" in found["ending"]


def test_what_would_take_too_long_is_not_begun_and_the_best_answer_is_given(folder, monkeypatch):
    true_cost = sequence.expected

    def dear(scene, before):
        cost = true_cost(scene, before)
        return Cost(cost.unknowns, 1e9 if len(before) == 2 else cost.seconds, 1e6)

    monkeypatch.setattr(sequence, "expected", dear)
    scene = Scene.read(DEMOS / "long_roller.toml", [*SMALL, "accuracy.tolerance=0.001 %"])
    result = run(scene, folder / "run")
    assert not result.done
    assert result.reason.startswith("level 2 would take about")
    found = answer_in(folder / "run")
    assert not found["met"]
    assert found["quantities"]["force"]["basis"] == "first order taken for granted"
    assert found["quantities"]["force"]["bar"] > 0
    assert result.folder == folder / "run" / "level_1"


def test_a_level_that_is_too_coarse_is_left_out(folder, monkeypatch):
    true_run = sequence.simulation.run

    def stopping(scene, at, comm, **options):
        if at.name == "level_0":
            return Result(False, "Newton's method did not converge", at, [])
        return true_run(scene, at, comm, **options)

    monkeypatch.setattr(sequence.simulation, "run", stopping)
    result = run(Scene.read(ONE, ["accuracy.tolerance=0.3 %", *QUIET]), folder / "run")
    assert result.done, result.reason
    assert [one["level"] for one in answer_in(folder / "run")["levels"]] == [1, 2, 3]


def test_a_level_that_is_late_stops_with_its_state(folder):
    scene = Scene.read(DEMOS / "long_roller.toml", SMALL)
    result = simulation.run(scene, folder, deadline=time.monotonic())
    assert not result.done
    assert result.reason.endswith("its time is up")


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("accuracy.tolerance='1'", "accuracy.tolerance = '1': expected a positive share in per cent with its unit"),
        ("accuracy.tolerance='-1 %'", r"accuracy.tolerance = '-1 %'"),
        ("accuracy.tolerance=0.01", r"accuracy.tolerance = 0.01: expected .* such as \"1 %\""),
        ("accuracy.most_time='5'", "accuracy.most_time = '5': expected a positive time"),
        ("accuracy.most_memory='4 s'", "accuracy.most_memory = '4 s': expected a positive amount of memory"),
        ("accuracy.quantities=['weight']", "accuracy.quantities.0 = 'weight': expected 'force', 'vf'"),
        ("accuracy.quantities=[]", "accuracy.quantities = .*: expected at least one"),
    ],
)
def test_what_cannot_be_asked_for_is_one_line(change, expected):
    with pytest.raises(SceneError, match=expected):
        Scene.read(ONE, [change])


def test_an_accuracy_reads_back_from_what_is_written():
    changes = ["accuracy.tolerance=0.7 %", "accuracy.most_time=2 h", "accuracy.most_memory=4 GB"]
    scene = Scene.read(ONE, changes)
    again = Scene.from_table(tomllib.loads(scene.to_toml()))
    assert again.accuracy == scene.accuracy
    assert (again.accuracy.tolerance, again.accuracy.most_memory) == (pytest.approx(0.007), 4e9)


@pytest.mark.serial
def test_what_a_scene_has_not_is_refused_and_nothing_is_written(tmp_path):
    words = ["--accuracy", "1 %", "--set", "accuracy.quantities=['void_volume']", "--out", tmp_path / "out"]
    ended = call("run", ONE, *words)
    assert ended.returncode == 2
    assert "expected one that this scene has: force, vf" in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_results_are_not_replaced_unasked_and_wholly_if_asked(folder):
    scene = Scene.read(ONE, ["accuracy.tolerance=50 %", *QUIET])
    run(scene, folder / "run")
    with pytest.raises(SceneError, match="holds results already"):
        run(scene, folder / "run")
    on_root(MPI.COMM_WORLD, (folder / "run" / "level_7").mkdir)
    assert run(scene, folder / "run", overwrite=True).done
    assert not (folder / "run" / "level_7").exists()


def level(number, force, lost=None):
    return Level(number, Path(f"level_{number}"), Cost(1000 * 2**number, 1.0, 1e8), 1.0, {"force": force}, lost)


@pytest.mark.parametrize(
    ("lost", "differ"),
    [
        ([None, None, None], False),
        ([None, None, 50.0], True),  # one is stable to the end, another is not
        ([60.0, 55.0, 53.0], False),  # they come closer
        ([60.0, 55.0, 40.0], True),
    ],
)
def test_levels_on_different_branches_are_told_and_have_their_spread(lost, differ):
    levels = [
        level(number, force, when) for number, (force, when) in enumerate(zip([1.0, 1.1, 1.15], lost, strict=True))
    ]
    answer = Answer(("force",), 0.01, tuple(levels))
    assert answer.branches is differ
    assert answer.estimates["force"].bar == pytest.approx(1.25 * (0.15 if differ else 0.05))
    assert ("different branches" in "\n".join(answer.lines)) is differ
