"""Rollers: of finite width with sharp and rounded ends, and without an end."""

import numpy as np
import pytest
from surfaces import BALL, CYLINDER, distance, points_about, tool

pytestmark = pytest.mark.serial


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


def test_rounded_ends_shrink_to_sharp_ones_on_the_side_of_the_fabric():
    nearly = tool(radius="2.5 mm", width="30 mm", edge="1e-9 m")
    for point in points_about(CYLINDER, 200, seed=9):
        if distance(CYLINDER, point) > 0:
            assert distance(nearly, point) == pytest.approx(distance(CYLINDER, point), abs=1e-9)


def test_a_roller_with_no_flat_left_is_a_sphere():
    ball = tool(radius="5 mm", width="10 mm", edge="5 mm")
    for point in points_about(ball, 100, seed=10):
        assert distance(ball, point) == pytest.approx(distance(BALL, point), abs=1e-15)
