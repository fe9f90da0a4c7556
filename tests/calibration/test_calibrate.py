"""From files to a fabric in a scene: the command as a whole, the choice of laws, and what is refused."""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from laws_by_number import VF0, law
from program import DEMOS
from raw_styles import MALFORMED
from synthetic import AREA, PAPER, moved, press, specimens

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.calibration.calibrate import Wishes, fit_tests
from ncf_fenicsx.calibration.command import Order, carry_out
from ncf_fenicsx.calibration.fitting import value_with_error
from ncf_fenicsx.calibration.specimens import Machine
from ncf_fenicsx.laws.compaction import Exponential

pytestmark = pytest.mark.serial
SPECIMEN = ["length=152 mm", "width=152 mm", "areal_density=1425 g/m^2", "fibre_density=1.79e6 g/m^3"]


def write(test, path):
    """A test as a file of a machine."""
    rows = [f"Layers;{test.layers}", f"Initial thickness;{1e3 * test.initial_thickness:g} mm", ""]
    rows += ["Zeit [s];Dicke [mm];Kraft [kN]"]
    columns = zip(test.time, 1e3 * test.apparent, test.force / 1e3, strict=True)
    rows += [";".join(f"{value:.9g}".replace(".", ",") for value in row) for row in columns]
    path.write_text("\n".join(rows), "utf-8")
    return path


def order(files, folder=None, laws=(), **more):
    usual = {"given": SPECIMEN, "free": [], "fixed": [], "machine": {}, "weight": "thickness", "title": "mine"}
    out = {"check": False} | {"out": folder and folder / "mine.toml", "picture": folder and folder / "mine.png"}
    return Order(files=list(files), laws=list(laws), **(usual | out | more))


def test_files_become_a_fabric_that_a_scene_takes(tmp_path):
    rng = np.random.default_rng(1)
    files = [write(test, tmp_path / f"{number}.csv") for number, test in enumerate(specimens(rng))]
    words, holds = carry_out(order(files, tmp_path))
    assert holds
    assert "thickness at given pressure" in words
    assert "| compaction.beta2 | 1.5" in words
    table = tomllib.loads((tmp_path / "mine.toml").read_text("utf-8"))
    assert len(table["fit"]["covariance"]) == len(table["fit"]["names"]) == 4
    assert set(table["sources"]) == {"stack", "laws.compaction", "laws.rate"}
    assert (tmp_path / "mine.png").stat().st_size > 1e4
    scene = Scene.read(DEMOS / "roller.toml", [f"fabric={tmp_path / 'mine.toml'}"])
    assert scene.laws.compaction.beta2 == pytest.approx(1.5238, rel=0.02)
    assert scene.stack.areal_density == 1.425


def test_the_page_has_the_numbers_the_data_and_the_laws(tmp_path):
    rng = np.random.default_rng(1)
    files = [write(test, tmp_path / f"{number}.csv") for number, test in enumerate(specimens(rng))]
    words, _ = carry_out(order(files, page=tmp_path / "mine.html", title="glass <b>"))
    shown = (tmp_path / "mine.html").read_text("utf-8")
    assert "<h1>Calibration: glass &lt;b&gt;</h1>" in shown
    numbers = [line.strip("| ").split(" | ") for line in words.splitlines() if line.startswith("| compaction")]
    assert len(numbers) > 1
    for name, value, error in numbers:
        assert f'<th scope="row">{name}</th><td>{value}</td><td>{error}</td>' in shown
    panels = json.loads(re.search(r'id="panels">(.*?)</script>', shown)[1])
    assert [panel["title"] for panel in panels] == ["Compaction", "Compaction over time", "Residuals"]
    measured, law = panels[0]["lines"][:2]
    assert (measured["apart"], law["traced"], measured["colour"]) == (True, True, law["colour"])
    assert len(measured["points"]) == len(law["points"]) > 10
    with pytest.raises(SceneError, match=r"--page .*ends with \.html"):
        carry_out(order(files, page=tmp_path / "mine.png"))


def test_the_criterion_finds_the_law_that_made_the_tests():
    power = PAPER | {"compaction": law("compaction", "power", exponent=12.0, scale="15 MPa")}
    fit = fit_tests(specimens(np.random.default_rng(3), power), Wishes({"compaction": "auto"}))
    assert fit.laws["compaction"].kind == "power"
    assert fit.compared["power"] == 0
    assert min(value for kind, value in fit.compared.items() if kind != "power") > 10
    value, error = value_with_error(fit, "compaction.exponent")
    assert abs(value - 12.0) < 4 * error < 0.4


def test_holds_and_unloading_are_fitted_where_there_are_some():
    laws = {
        "compaction": Exponential(),
        "rate": law("rate", "none"),
        "relaxation": law("relaxation", "maxwell", branches=[{"share": 0.1, "time": f"{10**n} s"} for n in (1, 2)]),
        "unloading": law("unloading", "permanent_set", set_share=0.4, exponent=2.5),
    }
    time = np.linspace(0, 500, 101)
    thickness = 1e-3 * np.interp(time, [0, 60, 360, 400, 500], [4, 2.8, 2.8, 3.1, 3.5])
    test = moved(laws, time, thickness, 4)
    fit = fit_tests([test], Wishes({}))
    assert set(fit.laws) == {"compaction", "rate", "relaxation", "unloading"}
    assert fit.scatter < 3e-3
    assert fit.laws["unloading"].set_share == pytest.approx(0.4, abs=0.03)


def test_curves_of_two_speeds_that_cross_are_refused_with_the_place():
    slow, fast = press(PAPER, 1, 4, 1), press(PAPER, 1, 4, 5)
    vf = fast.volume_fraction(Machine())
    crossed = replace(fast, force=fast.force * np.where(vf < 0.5, 1.0, 0.2))
    with pytest.raises(SceneError, match=r"cross at Vf 0\.\d+; expected the faster one above"):
        fit_tests([slow, crossed], Wishes({}))


@pytest.mark.parametrize(
    ("heading", "x", "y", "family", "expected"),
    [
        ("Angle [deg];Shear stress [kPa]", [0.1, 0.5, 1, 3, 7], [10.3, 23.4, 31.9, 50.1, 61.9], "shear", "61900.0 Pa"),
        ("Curvature [1/m];Moment [N]", [1, 2, 5, 10, 20], [0.12, 0.24, 0.32, 0.35, 0.38], "bending", "0.38"),
        ("Normal force [N];Friction force [N]", [10, 20, 40, 80], [3.1, 5.8, 12.2, 23.9], "friction", "0.3"),
        ("Vf [-];Permeability [m2]", [0.45, 0.5, 0.55], [1e-11, 6.47e-12, 4.2e-12], "permeability", "constant_along"),
    ],
)
def test_other_tests_find_their_law(tmp_path, heading, x, y, family, expected):
    file = tmp_path / "raw.csv"
    file.write_text(heading + "\n" + "\n".join(f"{a};{b}" for a, b in zip(x, y, strict=True)), "utf-8")
    words, _ = carry_out(order([file], tmp_path, given=[*SPECIMEN, "thickness=1 mm"]))
    assert words.startswith(family)
    table = tomllib.loads((tmp_path / "mine.toml").read_text("utf-8"))
    assert expected in (words if family == "permeability" else str(table))
    assert Scene.read(DEMOS / "roller.toml", [f"fabric={tmp_path / 'mine.toml'}"])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"laws": ["compaction=gutowsky"]}, "did you mean 'gutowski'?"),
        ({"given": SPECIMEN[:2]}, "no areal density; expected --given areal_density='1425 g/m^2'"),
        ({"given": [*SPECIMEN, "layers=4"]}, "line 41: a thickness of 3.178 mm, and fibres of 3.184 mm"),
        ({"given": ["layer=2"]}, "--given layer=2: expected one of layers"),
        ({"free": ["rate.alpha9"]}, "--free rate.alpha9: no such number"),
        ({"machine": {"compliance": "1 mm"}}, "--compliance 1 mm: expected a value of at least 0 in m/N, or fit"),
        ({"weight": "stress"}, "--weight stress: expected thickness or pressure"),
        ({"files": [Path("nowhere.csv")]}, "nowhere.csv: No such file"),
    ],
)
def test_what_is_wrong_is_one_line_and_nothing_is_written(tmp_path, changes, words):
    files = changes.pop("files", None) or [write(press(PAPER, 1, 4, 2), tmp_path / "a.csv")]
    with pytest.raises(SceneError) as caught:
        carry_out(order(files, tmp_path, **changes))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.glob("mine*"))


@pytest.mark.parametrize("name", MALFORMED)
def test_of_a_malformed_file_nothing_is_written(tmp_path, name):
    file = tmp_path / "raw.csv"
    file.write_text(MALFORMED[name][0], "utf-8")
    with pytest.raises(SceneError):
        carry_out(order([file], tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["raw.csv"]


def test_simulated_tests_give_the_data_back(tmp_path):
    rng = np.random.default_rng(2)
    tests = [press(PAPER, 1, 4, 1, rng), press(PAPER, 1, 8, 5, rng)]
    files = [write(test, tmp_path / f"{number}.csv") for number, test in enumerate(tests)]
    words, holds = carry_out(order(files, None, check=True))
    assert holds, words
    assert words.count("| yes |") == 2
    assert tests[0].force.max() / AREA > 1e4 > VF0


def test_a_table_of_moments_says_for_which_layers_it_holds(tmp_path):
    file = tmp_path / "bent.csv"
    file.write_text("Curvature [1/m];Moment [N]\n1;0.12\n2;0.24\n5;0.32\n", "utf-8")
    with pytest.raises(SceneError, match="no thickness; expected --given thickness="):
        carry_out(order([file], tmp_path))
    words, _ = carry_out(order([file], tmp_path, given=["thickness=1 mm"]))
    assert "it holds for layers of 1 mm" in words
    scene = Scene.read(DEMOS / "roller.toml", [f"fabric={tmp_path / 'mine.toml'}"])
    assert any("those of a layer of 1 mm, and layers of 2 mm have them times 2" in words for words in scene.cautions)
    same = Scene.read(DEMOS / "roller.toml", [f"fabric={tmp_path / 'mine.toml'}", "stack.thickness=1 mm"])
    assert not any("those of a layer" in words for words in same.cautions)


def test_a_law_that_such_tests_do_not_tell_is_refused(tmp_path):
    file = tmp_path / "bent.csv"
    file.write_text("Thickness;1 mm\nCurvature [1/m];Moment [N]\n1;0.12\n2;0.24\n5;0.32\n", "utf-8")
    with pytest.raises(SceneError, match="--law bending=mid_plane: expected one that such tests tell: table"):
        carry_out(order([file], tmp_path, ["bending=mid_plane"]))


@pytest.mark.parametrize(("travel", "force"), [([0, 0, 0, 0], [0, 1, 2, 3]), ([0, 0.1, 0.2, 0.3], [0, 0, 0, 0])])
def test_what_does_not_press_is_refused(tmp_path, travel, force):
    file = tmp_path / "a.csv"
    rows = "\n".join(f"{t};{x};{f}" for t, x, f in zip(range(4), travel, force, strict=True))
    file.write_text("Time [s];Travel [mm];Force [N]\n" + rows, "utf-8")
    with pytest.raises(SceneError, match="does not change; expected a test that presses"):
        carry_out(order([file], given=[*SPECIMEN, "thickness=4 mm", "layers=2"]))
