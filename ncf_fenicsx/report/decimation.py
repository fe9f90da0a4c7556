"""A mesh with fewer cells for pages: two by two of each layer become one, where the layers are regular in plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from ncf_fenicsx.grid_lines import grid_lines
from ncf_fenicsx.report.surfaces import Integers, Layers

FEWEST = 4
"""Cells along x and y from which on two are not made one."""


@dataclass(frozen=True)
class _Grid:
    """A layer that is regular in plan.

    Attributes:
        nodes: at the crossings of its lines, shape (along x, along y, levels).
        cells: between them, shape (along x, along y, levels).
    """

    nodes: Integers
    cells: Integers


def merged(layers: Layers) -> tuple[Layers, Integers] | None:
    """Layers with half as many cells along x and along y.

    A new cell has the mean of its cells by undeformed volume; a new node is one of the old ones, with its values.

    Returns:
        The layers, and the number that each of their nodes has in the old ones; None where a layer is not regular in
        plan, or has too few cells.
    """
    grids = [_grid(layers, number) for number in range(1, int(layers.layer.max()) + 1)]
    parts = [_merged(grid) for grid in grids if grid is not None]
    if len(parts) < len(grids) or min(min(grid.cells.shape[:2]) for grid in grids if grid is not None) < FEWEST:
        return None
    corners = np.concatenate([corner for corner, _ in parts])
    old = [cells for _, blocks in parts for cells in blocks]
    kept, numbers = np.unique(corners, return_inverse=True)
    mean = _means(old, layers.volumes())
    by_cell = {name: (mean @ values.T).T.astype(values.dtype) for name, values in layers.by_cell.items()}
    fewer = replace(
        layers,
        points=layers.points[kept],
        cells=numbers.reshape(corners.shape),
        layer=layers.layer[[cells[0] for cells in old]],
        nodes={name: values[:, kept] for name, values in layers.nodes.items()},
        by_cell=by_cell,
    )
    return fewer, kept


def _grid(layers: Layers, number: int) -> _Grid | None:
    """The grid of a layer; None where its nodes are not at all crossings of lines along x and y."""
    cells = np.flatnonzero(layers.layer == number)
    nodes, extent = np.unique(layers.cells[cells]), float(np.ptp(layers.points, axis=0).max())
    (x, column), (y, row) = (grid_lines(layers.points[nodes, axis], extent) for axis in (0, 1))
    levels, rest = divmod(len(nodes), len(x) * len(y))
    if rest or len(cells) != (len(x) - 1) * (len(y) - 1) * (levels - 1):
        return None
    if (np.bincount(column * len(y) + row, minlength=len(x) * len(y)) != levels).any():
        return None
    order = np.lexsort([layers.points[nodes, 2], row, column])
    grid = nodes[order].reshape(len(x), len(y), levels)
    centres = layers.points[layers.cells[cells]].mean(axis=1)
    middle = np.lexsort([centres[:, 2], np.searchsorted(y, centres[:, 1]), np.searchsorted(x, centres[:, 0])])
    return _Grid(grid, cells[middle].reshape(len(x) - 1, len(y) - 1, levels - 1))


def _merged(grid: _Grid) -> tuple[Integers, list[Integers]]:
    """Corners of the new cells in VTK's order, shape (cells, 8), and the old cells of each."""
    along, across, levels = grid.cells.shape
    columns, rows = (np.unique([*range(0, count, 2), count]) for count in (along, across))
    corners, old = [], list[Integers]()
    for left, right in pairwise(columns):
        for front, back in pairwise(rows):
            around = grid.nodes[[left, right, right, left], [front, front, back, back]]
            for level in range(levels):
                corners.append(np.concatenate([around[:, level], around[:, level + 1]]))
                old.append(grid.cells[left:right, front:back, level].ravel())
    return np.array(corners), old


def _means(old: list[Integers], volumes: NDArray[np.float64]) -> csr_array:
    """Matrix from values of the old cells to means by volume, shape (new cells, old cells)."""
    columns = np.concatenate(old)
    starts = np.concatenate([[0], np.cumsum([len(cells) for cells in old])])
    whole = np.repeat([volumes[cells].sum() for cells in old], np.diff(starts))
    return csr_array((volumes[columns] / whole, columns, starts), shape=(len(old), len(volumes)))
