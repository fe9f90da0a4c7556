"""Tools of a drawn profile against other tools and closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from surfaces import (
    MM,
    PROFILE,
    derivatives,
    distance,
    points_about,
    profile,
    tool,
)

pytestmark = pytest.mark.serial


def test_on_its_polyline_a_profile_has_derivatives():
    first, second = derivatives(PROFILE)
    point = (1e-3, 0.0, PROFILE.rounding)
    assert [part(point) for part in first] == [0.0, 0.0, -1.0]
    assert [part(point) for part in second] == [0.0] * 9


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
