"""Fewer cells for a page: means by volume, nodes that stay, layers that cannot be merged."""

import numpy as np
import pytest

from ncf_fenicsx.report.decimation import merged
from ncf_fenicsx.report.surfaces import Layers, neighbours

pytestmark = pytest.mark.serial


def stack(x, y, levels, layers=2, order=None):
    """Layers of a regular grid, each with nodes of its own, in an order that tells nothing."""
    grids, cells, layer = [], [], []
    for number in range(layers):
        start = sum(map(len, grids))
        z = number * 2.0 + np.linspace(0.0, 2.0, levels + 1)
        grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
        grids.append(grid.reshape(-1, 3))
        node = start + np.arange(len(grids[-1])).reshape(grid.shape[:3])
        low, high = slice(None, -1), slice(1, None)
        plan = [(low, low), (high, low), (high, high), (low, high)]
        corners = [node[a, b, c] for c in (low, high) for a, b in plan]
        cells.append(np.stack(corners, axis=-1).reshape(-1, 8))
        layer += [number + 1] * len(cells[-1])
    points, cells = np.concatenate(grids), np.concatenate(cells)
    mixed = np.random.default_rng(order).permutation(len(cells)) if order is not None else np.arange(len(cells))
    nodes = {f"displacement_{axis}": points[None, :, number] for number, axis in enumerate("xyz")}
    centre = points[cells[mixed]].mean(axis=1)
    fields = {"volume_fraction": np.stack([centre[:, 0], centre[:, 0] * centre[:, 1]])}
    return Layers(points, cells[mixed], np.array(layer)[mixed], np.array([0.0]), nodes, fields)


GRADED = np.array([0.0, 1.0, 1.5, 3.0, 3.2, 5.0, 6.0, 6.5])
EVEN = np.linspace(0.0, 4.0, 5)


@pytest.mark.parametrize("order", [None, 3])
def test_means_keep_the_integral_and_nodes_keep_their_values(order):
    fine = stack(GRADED, EVEN, levels=2, order=order)
    coarse, kept = merged(fine)
    assert len(coarse.cells) == 2 * 4 * 2 * 2  # seven cells become four
    assert np.allclose(coarse.points, fine.points[kept])
    assert np.allclose(coarse.nodes["displacement_y"], fine.nodes["displacement_y"][:, kept])
    assert np.isclose(coarse.volumes().sum(), fine.volumes().sum())
    values = [layers.by_cell["volume_fraction"] @ layers.volumes() for layers in (coarse, fine)]
    assert np.allclose(*values)
    centre = coarse.points[coarse.cells].mean(axis=1)
    assert np.allclose(coarse.by_cell["volume_fraction"][0], centre[:, 0])  # of a linear field the value at the centre
    assert sorted(set(coarse.layer)) == [1, 2]
    behind = neighbours(coarse.cells, coarse.layer)
    assert (behind < 0).sum() == 2 * 2 * (4 * 2 + 4 * 2 + 2 * 2)


def test_what_is_not_regular_or_too_small_stays():
    assert merged(stack(np.linspace(0, 1, 4), EVEN, 1)) is None
    odd = stack(EVEN, EVEN, 1)
    odd.points[7, 0] += 0.1
    assert merged(odd) is None
