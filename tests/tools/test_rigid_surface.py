"""What holds for every tool and mould: distances, normals, derivatives, sections, radii, refusals."""

import numpy as np
import pytest
import ufl
from surfaces import (
    BALL,
    FOOT,
    MM,
    MOULDS,
    NOTCHED,
    PLATE,
    PROFILE,
    ROUNDED,
    SURFACES,
    TOOLS,
    TOOTHED,
    derivatives,
    distance,
    gradient,
    points_about,
)

from ncf_fenicsx import Scene, SceneError

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(
    ("made", "point", "expected"),
    [
        (ROUNDED, (0, 0, -1), 1),
        (ROUNDED, (0, 13, 2), -2),
        (ROUNDED, (0, 15, 0), np.sqrt(2) - 1),
        (ROUNDED, (0, 14 + 3, 1 - 4), 4),
        (ROUNDED, (0, -14 - 3, 1 - 4), 4),
        (ROUNDED, (3.5, 14 + 2, 2.5), np.sqrt(8) - 1),
        (ROUNDED, (0, 18, 2.5), 3),
        (ROUNDED, (0, 14.3, 1 - 0.4), -0.5),
        (BALL, (0, 0, 0), 0),
        (BALL, (0, 0, 1), -1),
        (BALL, (3, 6, -1), np.sqrt(9 + 36 + 36) - 5),
        (FOOT, (7.9, -3.9, -1), 1),
        (FOOT, (1, 1, 1.5), -1.5),
        (FOOT, (1, 1, 5), -5),
        (FOOT, (8 + 3, 0, 2 - 4), 3),
        (FOOT, (-8 - 3, 0, 2 - 4), 3),
        (FOOT, (8 + 2, 4 + 3, 2 - 6), 5),
        (FOOT, (8 + 3, 4 + 4, 7), 3),
        (FOOT, (12, 0, 7), 2),
        (FOOT, (9.2, 0, 2), -0.8),
        (FOOT, (8.6, 4, 1.2), -1),
        (PLATE, (5, 5, -2), 2),
        (PROFILE, (0, 7, -1), 1),
        (PROFILE, (0, 7, 0.4), -0.4),
        (PROFILE, (2, 7, 1.5), -1.5),
        (PROFILE, (13, 7, 4), 2.5),
        (PROFILE, (-13, 7, 2.5 - 4), 4.5),
        (PROFILE, (9.5, 7, 9), -1),
        (NOTCHED, (5, 0, -1), 1),
        (NOTCHED, (5 + 3, 0, 0.5 - 4), 4.5),
        (NOTCHED, (0, 0, 3.5), -0.5),
        (NOTCHED, (0.1, 0, 3.5 + 0.5), -0.5 - np.sqrt(0.26)),
        (TOOTHED, (-6, 0, 5.5 - 3), 2.5),
        (TOOTHED, (-2, 0, 15), -2 * np.cos(np.arctan(1 / 4)) - 0.5),
        (MOULDS["ridge"], (0, 9, 1), 1),
        (MOULDS["ridge"], (12, 9, -4), 0),
        (MOULDS["ridge"], (12, 9, -20), -8),
        (MOULDS["trough"], (0, 9, 1), 1),
        (MOULDS["trough"], (12, 9, 4), 0),
        (MOULDS["trough"], (15, 9, 0), -5),
        (MOULDS["dome"], (4, 8, 1 - 20), -11),
        (MOULDS["dome"], (0, 12, -4), 0),
        (MOULDS["bowl"], (0, -12, 4), 0),
        (MOULDS["bowl"], (0, 0, -1), -1),
        (MOULDS["flat"], (7, 8, 2), 2),
    ],
)
def test_known_distances_in_mm(made, point, expected):
    assert distance(made, MM * np.array(point)) / MM == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", SURFACES)
def test_the_gradient_of_the_distance_is_a_unit_normal(name):
    for point in points_about(SURFACES[name], 60, seed=3):
        # a sharp end and its prolongation have no gradient
        if name != "cylinder" or abs(abs(point[1]) - 0.015) > 1e-6:
            assert np.linalg.norm(gradient(SURFACES[name], point)) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", [name for name in SURFACES if name != "cylinder"])
def test_the_distance_is_continuous(name):
    """Nowhere does it change by more than the point moves, down to the depth of the rounding."""
    ends = points_about(SURFACES[name], 16, seed=4).reshape(8, 2, 3)
    for start, end in ends:
        line = start + np.linspace(0, 1, 101)[:, None] * (end - start)
        steps = np.diff([distance(SURFACES[name], point) for point in line])
        assert np.abs(steps).max() <= np.linalg.norm(end - start) / 100 * (1 + 1e-9)


ACROSS = {
    "end of a roller": (ROUNDED, (0.3, 14, 0.2), (0, 1, 0)),
    "inner side of its rounding": (ROUNDED, (0, 15.2, 1), (0, 0, 1)),
    "edge of a foot": (FOOT, (8, 1, -0.5), (1, 0, 0)),
    "edge of a foot, inside": (FOOT, (8, 1, 0.5), (1, 0, 0)),
    "corner of a foot": (FOOT, (9, 4, 0.2), (0, 1, 0)),
    "wall of a foot": (FOOT, (10.5, 1, 2), (0, 0, 1)),
    "wall of a corner": (FOOT, (9.5, 5.5, 2), (0, 0, 1)),
    "corner of a profile": (PROFILE, (5, 1, -0.5), (1, 0, 0)),
    "its other side": (PROFILE, (5 + 0.5 * 0.4, 1, 0.5 - 0.5), (0.4, 0, -1)),
    "wall of a profile": (PROFILE, (10.6, 1, 2.5), (0, 0, 1)),
}


@pytest.mark.parametrize("case", ACROSS)
def test_the_normal_turns_without_a_jump_across_roundings(case):
    made, point, way = ACROSS[case]
    point, way = MM * np.array(point), np.array(way) / np.linalg.norm(way)
    before, after = (gradient(made, point + offset * way) for offset in (-3e-7, 3e-7))
    assert after == pytest.approx(before, abs=2e-3)


@pytest.mark.parametrize("name", SURFACES)
def test_first_and_second_derivatives_are_numbers(name):
    made = SURFACES[name]
    first, second = derivatives(made)
    deep = points_about(made, 12, seed=5) + np.array([0, 0, 1.5 * MM if made.family == "tool" else -1.5 * MM])
    for point in [*points_about(made, 12, seed=6), *deep, np.zeros(3)]:
        assert np.linalg.norm([part(tuple(point)) for part in first]) == pytest.approx(1, rel=1e-9)
        assert np.all(np.isfinite([part(tuple(point)) for part in second]))


@pytest.mark.parametrize("name", SURFACES)
def test_the_drawn_section_lies_on_the_surface(name):
    section = SURFACES[name].section()
    assert section.shape[1] == 2
    for x, z in section:
        assert distance(SURFACES[name], (x, 0.0, z)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", SURFACES)
def test_the_tip_is_on_the_surface_and_faces_the_fabric(name):
    made, up = SURFACES[name], 1 if SURFACES[name].family == "mould" else -1
    if name != "notched profile":
        assert distance(made, (0, 0, 0)) == 0.0
    assert distance(made, (0, 0, up * MM)) > 0


@pytest.mark.parametrize(
    ("name", "radii", "axle"),
    [
        ("cylinder", (2.5 * MM, None), 2.5 * MM),
        ("infinite cylinder", (2.5 * MM, None), 2.5 * MM),
        ("rounded cylinder", (2.5 * MM, 1 * MM), 2.5 * MM),
        ("sphere", (5 * MM, 5 * MM), 5 * MM),
        ("presser foot", (2 * MM, 2 * MM), None),
        ("plate", (None, None), None),
        ("profile", (0.5 * MM, None), None),
    ],
)
def test_radii_that_elements_follow_and_the_axle(name, radii, axle):
    assert TOOLS[name].radii == pytest.approx(radii)
    assert TOOLS[name].axle == (None if axle is None else pytest.approx(axle))


class Constants:
    """Constants that are numbers in UFL and nothing that Python can compare."""

    def __call__(self, value):
        return ufl.variable(ufl.as_ufl(value))

    def by_layer(self, values):
        return self(values[0])


@pytest.mark.parametrize("name", SURFACES)
def test_symbols_in_place_of_numbers_change_nothing(name):
    symbolic = SURFACES[name].with_constants(Constants())
    for point in points_about(symbolic, 20, seed=15):
        assert distance(symbolic, point) == pytest.approx(distance(SURFACES[name], point), abs=1e-15)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"edge": "3 mm"}, "tool.edge = 0.003: expected at most radius = 0.0025 m"),
        ({"width": "3 mm", "edge": "2 mm"}, "tool.edge = 0.002: expected at most width / 2 = 0.0015 m"),
        ({"edge": "-1 mm"}, "tool.edge = '-1 mm': expected a length of at least 0"),
        ({"kind": "sphere", "radius": "0 mm"}, "tool.radius = '0 mm': expected a positive length"),
        ({"kind": "sphere", "width": "3 mm"}, "tool.width = '3 mm': unknown key"),
        (
            {"kind": "presser_foot", "size": ["30 mm", "4 mm"]},
            "tool.size = [0.03, 0.004]: expected more than 2 edge = 0.004 m",
        ),
        ({"kind": "presser_foot", "edge": "0 mm"}, "tool.edge = '0 mm': expected a positive length"),
        ({"kind": "presser_foot", "size": ["30 mm"]}, "tool.size.1 = ['30 mm']: expected one more entry"),
        ({"kind": "profile", "points": [["0 mm", "0 mm"]]}, "expected at least 2 entries"),
        (
            {"kind": "profile", "points": [["1 mm", "0 mm"], ["1 mm", "2 mm"]]},
            "tool.points = [0.001, 0.001]: expected ascending x",
        ),
        ({"kind": "profile", "points": [["0 mm", "0 mm"], ["1 mm", "2"]]}, "tool.points.1.1 = '2': expected a length"),
        ({"kind": "profile", "rounding": "0 mm"}, "tool.rounding = '0 mm': expected a positive length"),
    ],
)
def test_a_wrong_tool_is_one_line_that_names_the_key(keys, expected):
    with pytest.raises(SceneError) as caught:
        Scene.from_table({"tool": keys})
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)
