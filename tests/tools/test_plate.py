"""What a plate is the limit of: a huge sphere, and the core of a foot."""

import pytest
from surfaces import FOOT, PLATE, distance, points_about, tool

pytestmark = pytest.mark.serial


def test_a_huge_sphere_is_a_plate():
    huge = tool("sphere", radius="1e4 m")
    for point in points_about(huge, 20, seed=7):
        assert distance(huge, point) == pytest.approx(distance(PLATE, point), abs=1e-7)


def test_the_core_of_a_foot_is_a_plate():
    for point in points_about(FOOT, 100, seed=8) * [8 / 12, 4 / 19, 1]:
        assert distance(FOOT, point) == pytest.approx(distance(PLATE, point), abs=1e-17)
