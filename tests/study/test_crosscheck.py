"""The kit judges other codes: its own march passes, and fails with a constant off; references are closed forms."""

import csv
import json
import re
import shutil

import numpy as np
import pytest
from program import DEMOS, call, script

from ncf_fenicsx import Scene, run
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.hexahedra import TAGS
from ncf_fenicsx.mesh.stack_file import read_stack
from ncf_fenicsx.mesh.stack_mesh import stack_of
from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.study.crosscheck import badge, holds, judge, read_kit

pytestmark = pytest.mark.serial

KIT = DEMOS / "crosscheck"
CONSTANTS = {
    "compaction": ("beta1", "beta2", "beta3"),
    "rate": ("alpha1", "alpha2", "alpha3", "sigma_0", "sigma_inf", "v_ref", "reference_thickness"),
    "relaxation": ("share", "time"),
    "unloading": ("set_share", "exponent"),
}
"""All but beta4, which the pressure is free of: it is that above the pressure at Vf0."""
UNIFORM = ["element", "hold", "unloading", "column"]
FIELDS = ["long_roller", "finite_roller", "sliding", "ruck"]
GENTLE = ["explicit.time_scaling=20", "explicit.safety=0.2", "explicit.damping=0.5", "output.fields_every=1000000"]
"""Settings of the explicit companion that keep swings below a thousandth of the force."""


@pytest.fixture(scope="module")
def marched(tmp_path_factory):
    """Histories of the kit's own march."""
    out = tmp_path_factory.mktemp("march")
    script(KIT / "march.py").main(out, {})
    return out


def rewritten(path, change):
    """A CSV file with a change of its rows, of which the first is the heading."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = change(list(csv.reader(file)))
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)


def test_the_march_passes_all(marched):
    verdicts = judge(marched, KIT, None)
    assert len([one for one in verdicts if one.passed]) == 16
    assert {one.history for one in verdicts if not one.passed} == set(FIELDS)
    assert re.fullmatch(r"cross-check of ncf_fenicsx \S+: 16 passed, 0 failed, 4 not given", badge(verdicts))


def test_the_march_fails_where_a_constant_is_off_by_a_twentieth(folder):
    script(KIT / "march.py").main(folder, {"unloading.exponent": 1.05})
    failed = [one for one in judge(folder, KIT, None) if one.passed is False]
    assert {(one.history, one.column) for one in failed} == {("unloading", "tool_force")}


@pytest.mark.slow
@pytest.mark.parametrize("key", [f"{law}.{name}" for law, names in CONSTANTS.items() for name in names])
def test_the_march_fails_with_any_constant_off_by_a_twentieth(folder, key):
    script(KIT / "march.py").main(folder, {key: 1.05})
    assert not holds(judge(folder, KIT, None))


@pytest.mark.slow
def test_the_explicit_companion_passes_and_fails_with_a_constant_off(folder):
    changes = ["tool.path.0.speed='5 mm/min'", "laws.in_plane.modulus='1 MPa'", "tool.penalty=200", *GENTLE]
    words = [word for change in changes for word in ("--set", change)]
    for name, more in (("right", []), ("wrong", ["--set", "laws.rate.sigma_inf='90120 Pa'"])):
        out = folder / name / "element_5_mm_min"
        assert call("explicit", KIT / "element" / "scene.toml", *words, *more, "--out", out).returncode == 0
    assert holds(judge(folder / "right", KIT, None))
    assert not holds(judge(folder / "wrong", KIT, None))


@pytest.mark.parametrize("speed", [1, 2, 5])
def test_references_of_one_element_are_the_closed_form_within_their_bars(speed):
    scene = Scene.read(KIT / "element" / "scene.toml", [f"tool.path.0.speed='{speed} mm/min'"])
    stored = read_history(KIT / "element" / f"element_{speed}_mm_min.csv")
    vf0, area = scene.stack.initial_volume_fraction, json.loads((KIT / "element" / "case.json").read_text())["area"]
    vf = vf0 / (1 - stored["tool_displacement"] / scene.stack.thickness)
    force = area * scene.laws.rate.factor(scene.segments[0].speed) * scene.laws.compaction.pressure(vf, vf0)
    assert (np.abs(stored["vf_mean"] - vf) <= stored["vf_mean_bar"]).all()
    assert (np.abs(stored["tool_force"] - force) <= stored["tool_force_bar"]).all()


def test_the_hold_relaxes_as_its_law_within_the_bars():
    stored = read_history(KIT / "hold" / "hold.csv")
    late = stored["time"] >= 30
    time, force = stored["time"][late] - 30, stored["tool_force"][late]
    rest = force[-1] - (force[0] - force[-1]) * np.exp(-3) / (1 - np.exp(-3))
    decay = rest + (force[0] - rest) * np.exp(-time / 10)
    assert (np.abs(force - decay) <= 3 * stored["tool_force_bar"][late].max()).all()


@pytest.mark.parametrize("case", UNIFORM + FIELDS)
def test_the_neutral_file_is_that_of_the_scene(case):
    stored = json.loads((KIT / case / "case.json").read_text("utf-8"))
    assert stored == json.loads(json.dumps(script(KIT / "references.py").neutral(case)))


def test_references_repeat_within_their_bars(folder):
    assert script(KIT / "references.py").repeats("element", "element_5_mm_min", folder)


@pytest.mark.slow
@pytest.mark.parametrize("case", UNIFORM[1:] + FIELDS)
def test_all_references_repeat_within_their_bars(case, folder):
    assert script(KIT / "references.py").repeats(case, case, folder)


@pytest.mark.parametrize("case", UNIFORM + FIELDS)
@pytest.mark.parametrize("ending", ["msh", "inp"])
def test_mesh_files_are_the_mesh_of_the_scene(case, ending):
    right = stack_of(Scene.read(KIT / case / "scene.toml"))
    found = read_stack(KIT / case / f"mesh.{ending}", int(right.layer.max()) + 1)
    centres = [stack.points[stack.cells].mean(axis=1) for stack in (found, right)]
    orders = [np.lexsort(places.round(9).T) for places in centres]
    assert centres[0][orders[0]] == pytest.approx(centres[1][orders[1]], abs=1e-9)
    assert (found.layer[orders[0]] == right.layer[orders[1]]).all()
    outside = np.where(right.face_tags > max(TAGS.values()), 0, right.face_tags)  # faces between layers have no group
    assert (found.face_tags[orders[0]] == outside[orders[1]]).all()
    assert len(found.points) == len(right.points)


def judged_run(folder, case, *changes):
    """Whether a coarser and faster run of a case passes as another code's, and how many columns count."""
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    run(Scene.read(KIT / case / "scene.toml", ["output.picture=false", "output.report=false", *changes]), out / case)
    verdicts = [one for one in judge(out, KIT, None) if one.passed is not None]
    return holds(verdicts), len(verdicts)


def test_a_coarser_run_of_the_long_roller_passes_and_fails_with_a_constant_off(folder):
    assert judged_run(folder, "long_roller") == (True, 3)
    assert judged_run(folder, "long_roller", "laws.compaction.beta2=1.6") == (False, 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "change"),
    [
        ("finite_roller", "laws.compaction.beta2=1.6"),
        ("finite_roller", "laws.bending.modulus='0.15 GPa'"),
        ("sliding", "interface.friction={coefficient=0.21,stiffness=10}"),
        ("ruck", "laws.bending.modulus='1.15 MPa'"),
    ],
)
def test_runs_of_the_coarse_level_pass_and_fail_with_a_constant_off(folder, case, change):
    references = script(KIT / "references.py")
    level = references.level_of_space(case, case, references.COARSE)
    assert judged_run(folder, case, *level)[0]
    assert not judged_run(folder, case, *level, change)[0]


def test_fewer_columns_and_histories_are_judged_on_what_is_there(marched, folder):
    shutil.copy(marched / "columns.toml", folder)
    shutil.copy(marched / "column.csv", folder)
    rewritten(folder / "column.csv", lambda rows: [[row[0], row[3]] for row in rows])
    verdicts = judge(folder, KIT, None)
    given = [one for one in verdicts if one.passed is not None]
    assert [(one.history, one.column, one.passed) for one in given] == [("column", "vf_mean", True)]
    assert holds(verdicts)
    assert "tool_force" in {one.column for one in verdicts if one.words == "no such column"}
    assert "no hold.csv" in {one.words for one in verdicts}


def test_sampling_is_free_and_a_shorter_history_is_said(marched, folder):
    shutil.copytree(marched, folder, dirs_exist_ok=True)
    rewritten(folder / "hold.csv", lambda rows: [rows[0], *rows[1:70:7]])
    (verdict,) = (one for one in judge(folder, KIT, None) if (one.history, one.column) == ("hold", "tool_force"))
    assert verdict.passed
    assert re.search(r"only 0\.4 to 25\.6 of time \(42 %\)", verdict.words)


def test_a_history_without_time_is_held_over_the_plates_travel(marched, folder):
    shutil.copytree(marched, folder, dirs_exist_ok=True)
    for name in ("element_1_mm_min", "unloading"):
        rewritten(folder / f"{name}.csv", lambda rows: [row[1:] for row in rows])
    verdicts = judge(folder, KIT, None)
    assert all(one.passed for one in verdicts if one.history == "element_1_mm_min")
    assert {one.words for one in verdicts if one.history == "unloading"} == {"no column time to hold it over"}


def test_a_difference_is_found_where_it_is(marched, folder):
    shutil.copytree(marched, folder, dirs_exist_ok=True)

    def bump(rows):
        rows[50][2] = str(1.2 * float(rows[50][2]))
        return rows

    rewritten(folder / "element_2_mm_min.csv", bump)
    (failed,) = (one for one in judge(folder, KIT, None) if one.passed is False)
    assert (failed.history, failed.column) == ("element_2_mm_min", "tool_force")
    assert f"at {50 / 150 * 20.4:.6g} s" in failed.words
    assert holds(judge(folder, KIT, 0.5))


def test_times_after_a_jump_are_not_judged(marched, folder):
    kit = shutil.copytree(KIT, folder / "kit")
    file = kit / "hold" / "case.json"
    case = json.loads(file.read_text("utf-8"))
    case["histories"]["hold"]["not_judged"] = [[0.0, 60.0]]
    file.write_text(json.dumps(case), encoding="utf-8")
    words = {one.words for one in judge(marched, kit, None) if one.history == "hold"}
    assert words == {"no row where it is judged"}


def test_the_command_says_what_failed(marched, folder):
    out = shutil.copytree(marched, folder / "out")
    for path in out.glob("*.csv"):
        if path.name != "unloading.csv":
            path.unlink()
    ended = call("crosscheck", out, "--kit", KIT)
    assert ended.returncode == 0
    assert "| unloading | tool_force | passed | off by" in ended.stdout
    assert "2 passed, 0 failed, 9 not given" in ended.stdout
    ended = call("crosscheck", out, "--kit", KIT, "--tolerance", "1e-6")
    assert ended.returncode == 1
    assert "| unloading | tool_force | FAILED |" in ended.stdout


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda out: [path.unlink() for path in out.glob("*.csv")], "has no history with a column to judge"),
        (lambda out: (out / "columns.toml").write_text("vf = 3"), "vf = 3; expected a text such as"),
        (lambda out: (out / "columns.toml").write_text("vf = "), "expected lines such as"),
        (lambda out: (out / "columns.toml").write_text("'t (ms)' = 'time [kg]'"), "column time in 'kg'"),
    ],
)
def test_mistakes_are_named(marched, folder, change, complaint):
    out = shutil.copytree(marched, folder / "out")
    change(out)
    with pytest.raises(SceneError, match=complaint):
        judge(out, KIT, None)


def test_a_folder_that_is_no_kit_is_named(marched, folder):
    with pytest.raises(SceneError, match=r"expected the folder demos/crosscheck"):
        judge(marched, folder, None)
    assert len(read_kit(KIT)) == 10
