"""What the view draws: who meets whom, which faces are outside, where tools are."""

import numpy as np
import pytest
from surfaces import distance, mould, tool

from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.surfaces import Layers, lines_under, mirrors, neighbours, rigid_surfaces

pytestmark = pytest.mark.serial
MM = 1e-3
WINDOW = ((-20 * MM, 30 * MM), (-10 * MM, 15 * MM))


def layers(folder):
    results = Results.read(folder)
    return results, Layers.read(results, [0, len(results.snapshots) - 1])


def test_neighbours_share_a_face_and_a_layer(results):
    _, drawn = layers(results)
    behind = neighbours(drawn.cells, drawn.layer)
    assert (behind < 0).sum() == 2 * 2 * (6 * 2 + 6 + 2)  # outside of two layers of 6 x 2 cells
    for cell, row in enumerate(behind):
        for other in row[row >= 0]:
            assert drawn.layer[cell] == drawn.layer[other]
            assert cell in behind[other]
            assert len(set(drawn.cells[cell]) & set(drawn.cells[other])) == 4


def test_faces_of_a_layer_and_lines_on_them(results):
    _, drawn = layers(results)
    top, bottom = drawn.face_nodes(2, True), drawn.face_nodes(1, False)
    assert len(top) == len(bottom) == 7 * 3
    assert np.allclose(drawn.points[top, 2], drawn.heights[1])
    assert np.allclose(drawn.points[bottom, 2], drawn.heights[0])
    lines = dict(lines_under(drawn, top, np.array([0.0, 0.0, 0.0])))
    assert len(lines["x"]) == 7
    assert len(lines["y"]) == 3
    assert np.allclose(drawn.points[lines["x"], 1], 0.0)
    assert (np.diff(drawn.points[lines["x"], 0]) > 0).all()


def test_volumes_sum_up_to_the_stack(results):
    _, drawn = layers(results)
    assert np.isclose(drawn.volumes().sum(), 12 * MM * 6 * MM * 4 * MM)


def test_tool_goes_where_the_history_says(results):
    read, drawn = layers(results)
    (found,) = rigid_surfaces(read, drawn)
    assert np.isclose(found["path"][0, 2] - found["path"][-1, 2], read.history["tool_displacement"][-1])
    assert [plane["axis"] for plane in mirrors(read, drawn)] == [0, 1]


@pytest.mark.parametrize(
    "surface",
    [
        tool("cylinder", width="infinite"),
        tool("sphere"),
        tool("plate"),
        tool("presser_foot"),
        tool("profile"),
        mould("plate"),
        *(mould(kind, shape=shape) for kind in ("cylinder", "sphere") for shape in ("convex", "concave")),
    ],
    ids=lambda surface: f"{surface.family} {surface.kind} {getattr(surface, 'shape', '')}",
)
def test_drawn_points_lie_on_the_surface(surface):
    grid = surface.surface(WINDOW).reshape(-1, 3)
    lower = grid[:: max(len(grid) // 60, 1)]
    assert max(abs(distance(surface, point)) for point in lower) < 2e-3 * np.ptp(grid, axis=0).max()


def test_a_surface_without_end_fills_the_window():
    grid = mould("plate").surface(WINDOW)
    assert np.allclose([grid[..., 0].min(), grid[..., 0].max()], WINDOW[0])
    assert np.allclose([grid[..., 1].min(), grid[..., 1].max()], WINDOW[1])
    ends = tool("cylinder", width="30 mm").surface(WINDOW)
    assert np.allclose([ends[..., 1].min(), ends[..., 1].max()], [-15 * MM, 15 * MM])
