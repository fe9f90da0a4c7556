"""Signed distances of the tools and moulds."""

from itertools import pairwise

import numpy as np
import pytest
import ufl
from basix.ufl import element
from pydantic import ValidationError
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.errors import one_line
from ncf_fenicsx.kinds import kinds

MM = 1e-3


def distance(surface, point):
    return float(ufl.as_ufl(surface.signed_distance(ufl.as_vector([float(c) for c in point])))(()))


def gradient(surface, point):
    offsets = 1e-7 * np.eye(3)
    return np.array([(distance(surface, point + d) - distance(surface, point - d)) / 2e-7 for d in offsets])


def derivatives(surface):
    """First and second derivatives of the distance as forms take them, each to be called with a point."""
    at = ufl.variable(ufl.SpatialCoordinate(ufl.Mesh(element("Lagrange", "hexahedron", 1, shape=(3,)))))
    first = ufl.diff(surface.signed_distance(at), at)
    second = ufl.diff(first, at)
    parts = [first[i] for i in range(3)], [second[i, j] for i in range(3) for j in range(3)]
    return [[apply_derivatives(apply_algebra_lowering(part)) for part in order] for order in parts]


def tool(kind="cylinder", **keys):
    return kinds("tool")[kind].model_validate(keys)


def mould(kind, **keys):
    return kinds("mould")[kind].model_validate(keys)


def profile(points, rounding):
    return tool("profile", points=[[f"{x!r} m", f"{z!r} m"] for x, z in points], rounding=rounding)


CYLINDER = tool(radius="2.5 mm", width="30 mm")
ROUNDED = tool(radius="2.5 mm", width="30 mm", edge="1 mm")
BALL = tool("sphere")
FOOT = tool("presser_foot", size=("20 mm", "12 mm"))
PLATE = tool("plate")
PROFILE = tool("profile")
NOTCHED = profile([(-6 * MM, 3 * MM), (-2 * MM, 1 * MM), (0, 2 * MM), (5 * MM, -1 * MM)], "0.5 mm")
TOOTHED = profile([(-6 * MM, 5 * MM), (-4 * MM, 13 * MM), (0, 12 * MM), (1 * MM, 0)], "0.5 mm")
TOOLS = {
    "cylinder": CYLINDER,
    "infinite cylinder": tool(width="infinite"),
    "rounded cylinder": ROUNDED,
    "sphere": BALL,
    "presser foot": FOOT,
    "plate": PLATE,
    "profile": PROFILE,
    "notched profile": NOTCHED,
}
MOULDS = {
    "ridge": mould("cylinder", radius="20 mm"),
    "trough": mould("cylinder", radius="20 mm", shape="concave"),
    "dome": mould("sphere", radius="20 mm"),
    "bowl": mould("sphere", radius="20 mm", shape="concave"),
    "flat": mould("plate"),
}
SURFACES = TOOLS | MOULDS


def points_about(surface, count, seed):
    """Points on the fabric's side, and inside less deep than the smallest rounding."""
    low, high = (-3.0, 0.4) if surface.family == "tool" else (-0.4, 3.0)
    return np.random.default_rng(seed).uniform([-12, -19, low], [12, 19, high], (count, 3)) * MM


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((0, 0, 0), 0.0),
        ((0, 0.01, -1e-3), 1e-3),
        ((0, 0.01, 1e-3), -1e-3),
        ((2.5e-3, 0, 2.5e-3), 0.0),
        ((0, 0.015 + 3e-3, -4e-3), 5e-3),
        ((0, 0.015 + 3e-3, 2.5e-3), 3e-3),
        ((0, 0.015 - 1e-4, 1e-3), -1e-3),
        ((0, 0.015, 1e-3), -1e-3),
        ((0, 0.015 + 1e-4, 1e-3), 1e-4),
    ],
)
def test_distance_from_a_roller_of_finite_width(point, expected):
    assert distance(CYLINDER, point) == pytest.approx(expected, abs=1e-15)


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


def test_a_sharp_roller_has_the_distance_it_always_had():
    r, half = CYLINDER.radius, CYLINDER.width / 2
    for x, y, z in points_about(CYLINDER, 200, seed=1):
        radial, axial = np.sqrt(x**2 + (z - r) ** 2) - r, abs(y) - half
        old = radial if axial <= 0 else np.hypot(max(radial, 0), axial)
        assert distance(CYLINDER, (x, y, z)) == pytest.approx(old, abs=1e-17)


def test_an_infinite_roller_is_the_limit_of_a_wide_one():
    infinite, wide = tool(width="infinite"), tool(width="10 m")
    for point in np.random.default_rng(2).uniform(-5e-3, 5e-3, (20, 3)):
        assert distance(infinite, point) == pytest.approx(distance(wide, point), rel=1e-12)


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


def test_on_its_polyline_a_profile_has_derivatives():
    first, second = derivatives(PROFILE)
    point = (1e-3, 0.0, PROFILE.rounding)
    assert [part(point) for part in first] == [0.0, 0.0, -1.0]
    assert [part(point) for part in second] == [0.0] * 9


def test_a_huge_sphere_is_a_plate():
    huge = tool("sphere", radius="1e4 m")
    for point in points_about(huge, 20, seed=7):
        assert distance(huge, point) == pytest.approx(distance(PLATE, point), abs=1e-7)


def test_the_core_of_a_foot_is_a_plate():
    for point in points_about(FOOT, 100, seed=8) * [8 / 12, 4 / 19, 1]:
        assert distance(FOOT, point) == pytest.approx(distance(PLATE, point), abs=1e-17)


def test_rounded_ends_shrink_to_sharp_ones_on_the_side_of_the_fabric():
    nearly = tool(radius="2.5 mm", width="30 mm", edge="1e-9 m")
    for point in points_about(CYLINDER, 200, seed=9):
        if distance(CYLINDER, point) > 0:
            assert distance(nearly, point) == pytest.approx(distance(CYLINDER, point), abs=1e-9)


def test_a_roller_with_no_flat_left_is_a_sphere():
    ball = tool(radius="5 mm", width="10 mm", edge="5 mm")
    for point in points_about(ball, 100, seed=10):
        assert distance(ball, point) == pytest.approx(distance(BALL, point), abs=1e-15)


def test_a_flat_profile_is_a_long_foot():
    flat = profile([(-8 * MM, 3.0), (8 * MM, 3.0)], "2 mm")
    foot = tool("presser_foot", size=("20 mm", "1 m"))
    for point in points_about(foot, 100, seed=11):
        assert distance(flat, point) == pytest.approx(distance(foot, point), abs=1e-15)


def test_points_on_a_straight_line_change_nothing():
    ends, many = ((-7 * MM, 0.0), (9 * MM, 4 * MM)), np.linspace(0, 1, 7)[:, None]
    one = profile(ends, "0.5 mm")
    several = profile((ends[0] + many * np.subtract(*ends[::-1])).tolist(), "0.5 mm")
    for point in points_about(one, 100, seed=12) * [1, 1, 3]:
        assert distance(several, point) == pytest.approx(distance(one, point), abs=1e-15)


def test_a_profile_of_a_circle_becomes_a_cylinder_with_the_square_of_its_points():
    cylinder, errors = tool(radius="2.5 mm", width="infinite"), []
    for count in (4, 8, 16):
        angle = np.linspace(-np.pi / 2, np.pi / 2, 2 * count + 1)
        made = profile(np.stack([2 * MM * np.sin(angle), -2 * MM * np.cos(angle)], axis=1).tolist(), "0.5 mm")
        line = [(x, 0.0, -0.5 * MM) for x in np.linspace(-2 * MM, 2 * MM, 49)]
        errors.append(max(abs(distance(made, point) - distance(cylinder, point)) for point in line))
    assert all(3.5 < coarse / fine < 4.5 for coarse, fine in pairwise(errors))
    assert errors[-1] < 1e-5


def test_the_lowest_point_of_a_profile_is_at_its_tip():
    made = profile([(-6 * MM, 3.003), (1 * MM, 3.001), (4 * MM, 3.002)], "1 mm")
    assert distance(made, (1 * MM, 0, 0)) == pytest.approx(0.0, abs=1e-15)
    assert min(z for _, z in made.section()) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("name", "kind"), [("ridge", "cylinder"), ("dome", "sphere")])
def test_a_convex_mould_is_a_tool_upside_down(name, kind):
    above = tool(kind, radius="20 mm", **({"width": "infinite"} if kind == "cylinder" else {}))
    for point in points_about(above, 20, seed=13):
        assert distance(MOULDS[name], point * [1, 1, -1]) == pytest.approx(distance(above, point), abs=1e-15)


@pytest.mark.parametrize("kind", ["cylinder", "sphere"])
def test_a_hollow_is_the_space_that_a_tool_fills(kind):
    inside = tool(kind, radius="20 mm", **({"width": "infinite"} if kind == "cylinder" else {}))
    hollow = mould(kind, radius="20 mm", shape="concave")
    for point in points_about(hollow, 20, seed=14):
        assert distance(hollow, point) == pytest.approx(-distance(inside, point), abs=1e-17)


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


def test_radii_of_the_moulds():
    radii = {name: made.radii for name, made in MOULDS.items()}
    one, both = (20 * MM, None), (20 * MM, 20 * MM)
    assert radii == {"ridge": one, "trough": one, "dome": both, "bowl": both, "flat": (None, None)}


class Symbols:
    """Symbols that are numbers in UFL and nothing that Python can compare."""

    def __call__(self, value):
        return ufl.variable(ufl.as_ufl(value))

    def by_layer(self, values):
        return self(values[0])


@pytest.mark.parametrize("name", SURFACES)
def test_symbols_in_place_of_numbers_change_nothing(name):
    symbolic = SURFACES[name].with_symbols(Symbols())
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


@pytest.mark.parametrize(
    ("kind", "keys", "expected"),
    [
        ("cylinder", {"shape": "flat"}, "shape = 'flat': expected 'convex' or 'concave'"),
        ("sphere", {"radius": "-1 mm"}, "radius = '-1 mm': expected a positive length"),
        ("plate", {"radius": "1 mm"}, "radius = '1 mm': unknown key"),
    ],
)
def test_a_wrong_mould_is_one_line_that_names_the_key(kind, keys, expected):
    with pytest.raises(ValidationError) as caught:
        mould(kind, **keys)
    assert expected in one_line(caught.value)
