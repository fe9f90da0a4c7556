"""Grid lines are told from coordinates that round-off has spread, wherever they lie."""

import numpy as np
import pytest

from ncf_fenicsx.grid_lines import grid_lines, places

LINES = 0.076 * (np.arange(81) / 80 * 0.15 + 0.85 * (np.arange(81) / 80) ** 2)
"""Those of a graded mesh: many of them end in a 5 after some digits."""


@pytest.mark.parametrize("offset", [-1e-17, 0.0, 1e-17])
def test_coordinates_of_a_line_are_of_one_line(offset):
    rng = np.random.default_rng(1)
    number = rng.permutation(np.repeat(np.arange(len(LINES)), 50))
    spread = LINES[number] * (1 + rng.choice([-3e-16, 0.0, 3e-16], len(number))) + offset
    lines, found = grid_lines(spread, 0.076)
    assert (found == number).all()
    assert lines == pytest.approx(LINES, abs=1e-15)


def test_one_line_is_one_line():
    lines, found = grid_lines(np.array([0.0, -3e-19, 1e-19]), 0.076)
    assert (len(lines), set(found)) == (1, {0})


def test_points_above_each_other_are_in_one_place():
    x, y, z = (part.ravel() for part in np.meshgrid(LINES, [0.0, 1e-3, 5e-3], [0.0, 2e-3], indexing="ij"))
    spread = np.stack([x + 1e-17 * (z > 0), y - 1e-17 * (z > 0)], axis=1)
    found = places(spread, 0.076).reshape(len(LINES), 3, 2)
    assert (found[:, :, 0] == found[:, :, 1]).all()
    assert len(np.unique(found)) == 3 * len(LINES)
