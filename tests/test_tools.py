"""Signed distances of the tools."""

import numpy as np
import pytest
import ufl

from ncf_fenicsx import Scene


def distance(tool, point):
    return float(ufl.as_ufl(tool.signed_distance(ufl.as_vector([float(c) for c in point])))(()))


def tool(**keys):
    return Scene.from_table({"tool": keys}).tool


CYLINDER = tool(kind="cylinder", radius="2.5 mm", width="30 mm")


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


def test_an_infinite_roller_is_the_limit_of_a_wide_one():
    rng = np.random.default_rng(2)
    infinite, wide = tool(width="infinite"), tool(width="10 m")
    for point in rng.uniform(-5e-3, 5e-3, (20, 3)):
        assert distance(infinite, point) == pytest.approx(distance(wide, point), rel=1e-12)


@pytest.mark.parametrize("made", [CYLINDER, tool(width="infinite"), tool(kind="plate")])
def test_the_gradient_of_the_distance_is_a_unit_normal(made):
    rng, step = np.random.default_rng(3), 1e-7
    for point in rng.uniform([-4e-3, -12e-3, -3e-3], [4e-3, 12e-3, 2e-3], (20, 3)):
        offsets = step * np.eye(3)
        gradient = [(distance(made, point + d) - distance(made, point - d)) / (2 * step) for d in offsets]
        assert np.linalg.norm(gradient) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("made", [CYLINDER, tool(kind="plate")])
def test_the_drawn_section_lies_on_the_surface(made):
    for x, z in made.section()[::20]:
        assert distance(made, (x, 0.0, z)) == pytest.approx(0.0, abs=1e-15)
