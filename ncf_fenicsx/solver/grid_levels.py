"""Coarser and coarser grids of a stack whose nodes stand on the lines of a grid, for multigrid.

From grid to grid every other line goes, along the axis whose lines are nearest to each other and those whose lines are
up to twice as far apart: what couples most is coarsened first, until lengths of elements differ by no more than a
factor of two, as smoothing one node after the other asks for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.grid_lines import grid_lines

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

COARSE_ENOUGH = 800
"""Nodes whose factors cost next to nothing."""
NEAR = 2.1
"""Times the least distance of lines up to which those of an axis go with them: two, and room for round-off.

Equal lengths would need one more grid, half as large as the one before it, and hardly fewer Krylov steps.
"""
LEAST_SHARE = 1e-12
"""Share of a coarse node in the motion of a fine one that is more than round-off."""
UPWARD = 2
"""Axis along which bodies lie above each other."""


def between(places: Floats, kept: Integers) -> tuple[Integers, Floats]:
    """The kept lines that each line of an axis lies between, and its shares in them, both of shape (lines, 2).

    Args:
        places: of the lines in m, ascending.
        kept: numbers of some of them, the first and the last included.
    """
    numbers = np.arange(len(places))
    below = np.searchsorted(kept, numbers, side="right") - 1
    above = np.searchsorted(kept, numbers)
    start, end = places[kept[below]], places[kept[above]]
    length = np.where(above > below, end - start, 1.0)
    share = (places - start) / length
    return np.stack([below, above], axis=1), np.stack([1.0 - share, share], axis=1)


@dataclass(frozen=True)
class Axis:
    """Lines of a grid along one axis.

    Attributes:
        places: of the lines in m, ascending within a part.
        parts: number of the body that each line belongs to, where an axis runs through several.
    """

    places: Floats
    parts: Integers

    @property
    def spacing(self) -> float:
        """Median distance of neighbouring lines in m."""
        within = np.diff(self.parts) == 0
        return float(np.median(np.diff(self.places)[within])) if within.any() else np.inf

    @property
    def kept(self) -> Integers:
        """Numbers of every other line of each part, its first and last ones included."""
        numbers = np.arange(len(self.places))
        starts = np.searchsorted(self.parts, self.parts)
        lasts = np.searchsorted(self.parts, self.parts, side="right") - 1
        return np.flatnonzero(((numbers - starts) % 2 == 0) | (numbers == lasts))


@dataclass(frozen=True)
class Grid:
    """Nodes at all crossings of the lines of three axes.

    Attributes:
        axes: of x, y and z.
        numbers: global number of each node, shape (lines of x, of y, of z).
        starts: first number of each rank, and the number of all nodes.
        free: which displacements of the nodes are not given, in the order of global numbers, shape (nodes, 3).
    """

    axes: tuple[Axis, Axis, Axis]
    numbers: Integers
    starts: Integers
    free: NDArray[np.bool_]

    def kept(self) -> list[Integers] | None:
        """Numbers of the lines along each axis that the next grid keeps; None if this one is coarse enough."""
        kept = [axis.kept for axis in self.axes]
        least = min(
            (axis.spacing for axis, lines in zip(self.axes, kept, strict=True) if len(lines) < len(axis.places)),
            default=None,
        )
        if least is None or self.numbers.size <= COARSE_ENOUGH:
            return None
        return [
            lines if axis.spacing <= NEAR * least else np.arange(len(axis.places))
            for lines, axis in zip(kept, self.axes, strict=True)
        ]

    def coarser(self, kept: list[Integers]) -> Grid:
        """The grid of some of the lines; each node stays with the rank that has it."""
        x, y, z = (Axis(axis.places[lines], axis.parts[lines]) for axis, lines in zip(self.axes, kept, strict=True))
        numbers = self.numbers[np.ix_(*kept)]
        finer, places = np.unique(numbers, return_inverse=True)
        return Grid((x, y, z), places.reshape(numbers.shape), np.searchsorted(finer, self.starts), self.free[finer])

    def shares(self, kept: list[Integers], coarse: Grid, own: slice) -> tuple[Integers, Floats]:
        """Coarse nodes that own nodes lie between, and their shares in them; both (nodes, 8), some shares none."""
        place = np.argsort(self.numbers.ravel())[own]
        crossings = np.unravel_index(place, self.numbers.shape)
        ends = [between(axis.places, lines) for axis, lines in zip(self.axes, kept, strict=True)]
        lines = [found[at] for (found, _), at in zip(ends, crossings, strict=True)]
        along = [share[at] for (_, share), at in zip(ends, crossings, strict=True)]
        corners = list(np.ndindex(2, 2, 2))
        nodes = [coarse.numbers[lines[0][:, i], lines[1][:, j], lines[2][:, k]] for i, j, k in corners]
        shares = [along[0][:, i] * along[1][:, j] * along[2][:, k] for i, j, k in corners]
        return np.stack(nodes, axis=1), np.stack(shares, axis=1)


def grid_of(ranks: MPI.Comm, positions: Floats, sublaminates: Integers, constrained: NDArray[np.int32]) -> Grid | None:
    """The grid that all nodes stand on; None if they do not, or not at all of its crossings.

    Args:
        ranks: that share the nodes.
        positions: of this rank's owned nodes in m, shape (nodes, 3).
        sublaminates: number of the body that each of them belongs to; bodies lie above each other.
        constrained: dofs of these nodes whose displacement is given.
    """
    nodes, bodies = (np.concatenate(ranks.allgather(own)) for own in (positions, sublaminates))
    free = np.ones((len(positions), 3), dtype=bool)
    free.ravel()[constrained] = False
    extent = float(np.ptp(nodes, axis=0).max())
    found = [_axis(nodes[:, along], bodies if along == UPWARD else np.zeros_like(bodies), extent) for along in range(3)]
    x, y, z = (axis for axis, _ in found)
    shape = (len(x.places), len(y.places), len(z.places))
    if math.prod(shape) != len(nodes):  # of nodes in no order there are more crossings than fit into memory
        return None
    crossings = np.ravel_multi_index([lines for _, lines in found], shape)
    if len(np.unique(crossings)) < len(nodes):
        return None
    starts = np.append(0, np.cumsum(ranks.allgather(len(positions))))
    return Grid((x, y, z), np.argsort(crossings).reshape(shape), starts, np.concatenate(ranks.allgather(free)))


def _axis(coordinates: Floats, bodies: Integers, extent: float) -> tuple[Axis, Integers]:
    """Lines of each body along an axis, one body after the other, and the line of each node."""
    places, parts, line = list[Floats](), list[Integers](), np.empty(len(coordinates), dtype=np.int64)
    for body in np.unique(bodies):
        within = bodies == body
        lines, numbers = grid_lines(coordinates[within], extent)
        line[within] = sum(map(len, places)) + numbers
        places.append(lines)
        parts.append(np.full(len(lines), body))
    return Axis(np.concatenate(places), np.concatenate(parts)), line


def motions_of_grids(comm: Any, grid: Grid) -> list[Any]:
    """Matrices from the displacements of each coarser grid to those of the one before, linear between its lines.

    Args:
        comm: ranks that share the nodes.
        grid: of all nodes, the finest.
    """
    motions = list[Any]()
    while (kept := grid.kept()) is not None:
        coarse = grid.coarser(kept)
        own = slice(*grid.starts[comm.rank : comm.rank + 2])
        nodes, shares = grid.shares(kept, coarse, own)
        size = int(np.diff(coarse.starts)[comm.rank])
        motions.append(_matrix(comm, nodes, shares, size, (grid.free[own], coarse.free)))
        grid = coarse
    return motions


def _matrix(
    comm: Any, nodes: Integers, shares: Floats, size: int, free: tuple[NDArray[np.bool_], NDArray[np.bool_]]
) -> Any:
    """Shares of coarse nodes in own ones, as a matrix for displacements: none where one of the two is given."""
    columns = 3 * nodes[:, None, :] + np.arange(3)[:, None]
    values = shares[:, None, :] * free[0][:, :, None] * free[1].ravel()[columns]
    share = np.broadcast_to(shares[:, None, :] > LEAST_SHARE, columns.shape)  # what is given stays in the pattern
    ends = np.append(0, np.cumsum(share.sum(axis=2).ravel()))
    matrix = PETSc.Mat().createAIJ(
        ((3 * len(nodes), None), (3 * size, None)),
        csr=(ends.astype(PETSc.IntType), columns[share].astype(PETSc.IntType), values[share]),
        comm=comm,
    )
    matrix.setBlockSizes(3, 3)
    matrix.assemble()
    return matrix
