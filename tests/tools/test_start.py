"""Distances of many points at once are those of each point alone; whether a surface starts in the stack."""

import numpy as np
import pytest
import ufl
from surfaces import SURFACES, distance, mould, points_about, tool

from ncf_fenicsx import SceneError
from ncf_fenicsx.tools.plate import Plate
from ncf_fenicsx.tools.start import check_depth, depth_at_start, distances

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("name", SURFACES)
def test_many_distances_at_once_are_those_of_each_point(name):
    surface = SURFACES[name]
    points = np.vstack([points_about(surface, 200, 3), np.zeros(3)])
    assert distances(surface, points) == pytest.approx([distance(surface, point) for point in points], abs=1e-15)


def test_a_tool_in_other_operators_is_worked_out_point_by_point():
    class Own(Plate):
        """Not in the table of operators."""

        def signed_distance(self, point):
            return ufl.dot(point, ufl.as_vector([0.0, 0.0, -1.0])) - 1e-3 * ufl.sin(point[0])

    points = points_about(tool("plate"), 5, 3)
    surface = Own.model_construct(**dict(tool("plate")))
    assert distances(surface, points) == pytest.approx(-points[:, 2] - 1e-3 * np.sin(points[:, 0]), abs=1e-15)


@pytest.mark.parametrize(("surface", "sign"), [(tool("sphere", radius="5 mm"), 1), (mould("plate"), -1)])
def test_a_surface_has_to_move_away_by_what_it_is_in_the_stack(surface, sign):
    point = np.array([[0.0, 0.0, sign * 3e-4]])
    depth = depth_at_start(surface, np.zeros(3), lambda tip: float(distances(surface, point - tip).min()), 1e-9)
    assert depth == pytest.approx(3e-4, abs=2e-9)
    with pytest.raises(SceneError, match=r"it.clearance = 0 mm: it starts 0.3 mm inside the stack"):
        check_depth("it", surface, depth)
    check_depth("it", surface, 0.0)
