"""What the picture of a run shows: a window with the tools and all that is not flat, its scale, a view in space."""

import json

import meshio
import numpy as np
import pytest
from matplotlib.figure import Figure

from ncf_fenicsx import Scene, run
from ncf_fenicsx.report import summary_picture
from ncf_fenicsx.report.reading import varies_along_y
from ncf_fenicsx.report.sections import Section, Window, cut, draw_section, window_of
from ncf_fenicsx.report.side_view import draw_side_view

pytestmark = pytest.mark.serial

FOOT = {"kind": "presser_foot", "size": ["10 mm", "10 mm"], "edge": "1 mm", "position": ["15 mm", "0 mm"]}
PRESS = {"travel": ["0 mm", "0 mm", "-0.1 mm"], "speed": "1 mm/min"}
HELD = {"x_min": "fixed", "x_max": "free"}


def scene(sides=HELD, **keys):
    stack = {"layers": 1, "size": ["200 mm", "20 mm"], "divisions": [200, 4], "grading": [0, 0], "sides": sides}
    return Scene.from_table({"stack": stack, "tool": FOOT | {"path": [PRESS]}} | keys)


def section_of(lift):
    """Section of a layer of 200 mm and 2 mm in cells of 1 mm, lifted by a function of x in m."""
    x = np.linspace(0, 200e-3, 201)
    low, high = np.column_stack([x, lift(x)]), np.column_stack([x, lift(x) + 2e-3])
    quads = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    return Section(quads, quads.mean(axis=1), np.ones(200, dtype=int), np.linspace(0.4, 0.5, 200))


def wave(x, centre=120e-3, half=20e-3, height=5e-3):
    return np.where(abs(x - centre) < half, height * np.cos(np.pi * (x - centre) / half / 2) ** 2, 0.0)


TIP = np.array([15e-3, 0.0, 1.9e-3])


def test_the_window_holds_the_whole_foot_and_the_whole_wave_and_no_more():
    flat, waved = section_of(lambda x: 0 * x), section_of(wave)
    window = window_of([flat, waved], [[TIP], [TIP]], scene())
    assert window.x[0] < 10e-3
    assert 138e-3 < window.x[1] < 150e-3  # the last degrees of the wave are flat
    assert window.z[0] < 0
    assert window.z[1] > 7e-3
    alone = window_of([flat], [[TIP]], scene())
    assert alone.x[0] <= 8e-3
    assert 20e-3 < alone.x[1] < 60e-3


def test_a_wave_is_mirrored_with_the_stack():
    window = window_of([section_of(wave)], [[TIP]], scene({"x_max": "free"}))
    assert window.x[0] == pytest.approx(-window.x[1], rel=1e-9)
    assert window.x[1] > 138e-3


@pytest.mark.parametrize(
    ("x", "z", "exaggeration", "words"),
    [
        ((0.0, 80e-3), (0.0, 10e-3), 1, "to scale"),
        ((0.0, 80e-3), (0.0, 4e-3), 2, "heights drawn 2 times as large as lengths"),
        ((0.0, 1.0), (0.0, 10e-3), 10, "heights drawn 10 times as large as lengths"),
    ],
)
def test_the_scale_is_the_least_that_can_be_read_and_is_said(x, z, exaggeration, words):
    window = Window(x, z)
    assert window.exaggeration == exaggeration
    assert window.scale == words
    axes = Figure().subplots()
    draw_section(axes, section_of(wave), scene(), [TIP], window, (0.4, 0.5))
    assert axes.get_aspect() == exaggeration
    assert axes.get_xlim() == pytest.approx([1e3 * value for value in x])


def bent(mesh, centre=6e-3, across=None):
    """A wave of 4 mm in a field file, as wide as it likes along y or not."""
    x, y, _ = mesh.points.T
    along_y = 1.0 if across is None else np.exp(-((y / across) ** 2))
    mesh.point_data["displacement"][:, 2] += 4e-3 * np.exp(-(((x - centre) / 2e-3) ** 2)) * along_y
    return mesh


@pytest.fixture
def results(folder, table):
    """Results of a short press of a roller on two layers."""
    table["solver"] = {"max_steps": 3}
    return run(Scene.from_table(table | {"output": {"picture": False, "fields_every": 1}}), folder / "run").folder


def panels(monkeypatch, folder):
    """Titles of the panels of a summary, which is drawn."""
    drawn = []
    original = summary_picture._panels
    monkeypatch.setattr(summary_picture, "_panels", lambda *given: drawn.append(original(*given)) or drawn[-1])
    assert summary_picture.draw_summary(folder).stat().st_size > 1e4
    figure, axes = drawn[-1]
    return figure.get_suptitle(), {name: panel.get_title() for name, panel in axes.items()}


def test_a_summary_says_the_wrinkle_and_shows_it_in_space_where_it_varies(monkeypatch, results):
    last = max((results / "fields").glob("*.vtu"))
    words, titles = panels(monkeypatch, results)
    assert "no wrinkle" in words
    assert titles["contact"] == "Voids between the layers"
    assert "space" not in titles
    record = json.loads((results / "run.json").read_text())
    record |= {"wrinkle": "a wrinkle 4 mm high", "wrinkle_measures": {"y_m": 0.0}}
    (results / "run.json").write_text(json.dumps(record))
    flat = meshio.read(last)
    for across, in_space in ((None, False), (2e-3, True)):
        mesh = bent(meshio.read(last), across=across)
        assert varies_along_y(mesh) == in_space
        mesh.write(last)
        words, titles = panels(monkeypatch, results)
        assert "a wrinkle 4 mm high" in words
        assert titles["contact"] == "Highest wrinkle"
        assert titles.get("space", "").startswith("Seen from the side at the end, " if in_space else "")
        assert ("space" in titles) == in_space
        flat.write(last)


def test_the_view_in_space_has_the_top_and_the_sides_at_a_scale_that_it_says(results):
    mesh = bent(meshio.read(max((results / "fields").glob("*.vtu"))), across=2e-3)
    axes = Figure().add_subplot(projection="3d")
    made = Scene.read(results / "scene.toml")
    tip = np.array([0.0, 0.0, 4e-3])
    skin = draw_side_view(axes, mesh, made, [tip])
    assert skin.get_array().max() > 2  # mm, means of faces
    assert len(axes.lines) == 2 * len(made.tool)
    assert "to scale" in axes.get_title()
    thin = mesh.copy()
    thin.point_data["displacement"] *= 0
    thin.points[:, 2] /= 100
    draw_side_view(axes, thin, made, [])
    assert "times as large as lengths" in axes.get_title()


def test_a_cut_has_its_corners_anticlockwise_from_the_lower_left(results):
    section = cut(meshio.read(max((results / "fields").glob("*.vtu"))), 0.0)
    low_left, low_right, high_right, high_left = section.quads.transpose(1, 0, 2)
    assert np.all(low_right[:, 0] > low_left[:, 0])
    assert np.all(high_right[:, 0] > high_left[:, 0])
    assert np.all(high_left[:, 1] > low_left[:, 1])
    assert np.all(high_right[:, 1] > low_right[:, 1])


def test_the_profile_is_that_of_one_column_nearest_to_the_tip_at_each_time():
    """Of a layer in cells of 1 mm whose Vf grows along x, with the tip between two columns and then elsewhere."""
    flat = section_of(np.zeros_like)
    tips = [[np.array([0.02, 0.0, 2e-3])], [np.array([0.1503, 0.0, 2e-3])]]
    axes = Figure().subplots()
    summary_picture._draw_profile(axes, [flat, flat], [(1.0, ""), (2.0, "")], tips, scene())
    first, second = (line.get_xdata() for line in axes.lines[:2])
    assert first == pytest.approx(flat.values[[19]])
    assert second == pytest.approx(flat.values[[150]])
