"""What all layers of a stack do alike: a coarse space for its tangent.

Layers in contact bend together: all nodes of a column move alike, and the layers turn alike, or a little more from
layer to layer, as where the stack is pressed on one side. No layer by itself shows how soft that is, nor do all heights
without the turns. What is soft is smooth: the motions of some columns do on fine meshes, linear between them. These
are few unknowns then, and their factors cost next to nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.grid_lines import grid_lines
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.galerkin import galerkin
from ncf_fenicsx.solver.grid_levels import LEAST_SHARE, between

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOTIONS = 10
"""Of a column: three displacements and two turns, each alike through the stack, and in proportion to the height in it.

The latter take a third to a half of the Krylov steps away, all five together; some of them, or without the thickness
that changes, hardly any.
"""
AXES, ORDER = np.array([0, 0, 0, 0, 1, 1, 1, 1, 2, 2]), np.array([0, 3, 5, 8, 1, 4, 6, 9, 2, 7])
"""Axis along which each of them displaces nodes, and its place among those of a column."""
LEAST_LINES, APART = 14, 4
"""Lines along an axis that are left at least where only every so many-th is taken, and how many-th at most: with all of
them GMRES takes the same steps, or one less; with fewer lines it takes more."""


class ColumnMotions:
    """Galerkin's approximation of a stack's tangent by what all its layers do alike, and its factors.

    Args:
        symmetric: LDL^T if so, else LU.
        space: from `motions_of_columns`.
    """

    def __init__(self, symmetric: bool, space: Any) -> None:
        self._space = space
        self._matrix: Any = None
        self._factors = DirectFactors(space.comm, symmetric, "ncf_part_")
        self._load, self._motion = space.createVecRight(), space.createVecRight()

    def factorise(self, matrix: Any) -> int:
        """Factors for a matrix; PETSc's reason why there are none, 0 if there are."""
        self._matrix = galerkin(matrix, self._space, self._matrix)
        return self._factors.factorise(self._matrix)

    def forget(self) -> None:
        """Forget all, the order of elimination included."""
        self._factors.forget()
        self._matrix = None

    def follow(self, load: Any, displacement: Any) -> None:
        """Add to a displacement how the columns follow a load."""
        self._space.multTranspose(load, self._load)
        self._factors.solve(self._load, self._motion)
        self._space.multAdd(self._motion, displacement, displacement)


def motions_of_columns(
    comm: Any, positions: Floats, sublaminates: Integers, layers: int, constrained: NDArray[np.int32]
) -> Any | None:
    """Matrix from the motions of all columns to the displacements of all nodes.

    Args:
        comm: ranks that share the tangent.
        positions: of this rank's owned nodes in m, shape (nodes, 3).
        sublaminates: layer of each of these nodes; layers that share nodes count as one.
        layers: number of them on all ranks.
        constrained: owned dofs whose displacement is given.

    Returns:
        None where nodes of the layers do not all stand above each other, so that there are no columns.
    """
    ranks = comm.tompi4py()
    found = _columns(ranks, positions[:, :2], sublaminates, layers)
    if found is None:
        return None
    columns, shares, taken = found
    one, stack = np.ones(len(positions)), np.zeros_like(sublaminates)
    within = _relative(ranks, positions[:, 2], sublaminates, layers)
    through = _relative(ranks, positions[:, 2], stack, 1)
    turns = [one, within, through, within * through]
    motions = np.stack([*turns, *turns, one, through], axis=1)
    return _matrix(comm, MOTIONS * columns, shares, MOTIONS * taken, motions, constrained)


def _columns(ranks: MPI.Comm, plan: Floats, sublaminates: Integers, layers: int) -> tuple[Integers, Floats, int] | None:
    """Columns taken that each owned node stands between, and its shares in them, both (nodes, 4), and how many.

    Where columns do not stand at all crossings of their lines along x and y, each is taken: both are (nodes, 1) then.
    None where one of them lacks a layer: its motions would not be independent.
    """
    before = sum(ranks.allgather(len(plan))[: ranks.rank])
    own, everywhere = slice(before, before + len(plan)), np.concatenate(ranks.allgather(plan))
    extent = float(np.ptp(everywhere, axis=0).max())
    lines, numbers = zip(*(grid_lines(along, extent) for along in everywhere.T), strict=True)
    shape = [len(along) for along in lines]
    crossings, column = np.unique(np.ravel_multi_index(numbers, shape), return_inverse=True)
    nodes = np.bincount(layers * column + np.concatenate(ranks.allgather(sublaminates)))
    if len(nodes) < layers * len(crossings) or nodes.min() < 2:
        return None
    if len(crossings) < shape[0] * shape[1]:
        return column[own, None], np.ones((len(plan), 1)), len(crossings)
    kept = [_some(count) for count in shape]
    (x, x_shares), (y, y_shares) = (
        [of_lines[number[own]] for of_lines in between(along, some)]
        for number, along, some in zip(numbers, lines, kept, strict=True)
    )
    columns = len(kept[1]) * x[:, :, None] + y[:, None, :]
    shares = x_shares[:, :, None] * y_shares[:, None, :]
    return columns.reshape(-1, 4), shares.reshape(-1, 4), len(kept[0]) * len(kept[1])


def _some(lines: int) -> Integers:
    """Numbers of the lines that are taken, the first and the last among them."""
    apart = min(max(lines // LEAST_LINES, 1), APART)
    return np.unique(np.append(np.arange(0, lines, apart), lines - 1))


def _relative(ranks: MPI.Comm, heights: Floats, bodies: Integers, count: int) -> Floats:
    """Height of each owned node in its body, a layer or the stack, from -1 at the bottom to 1 at the top."""
    ends = np.full((2, count), np.inf)
    for side, values in zip(ends, (heights, -heights), strict=True):
        np.minimum.at(side, bodies, values)
    bottom, top = np.min(ranks.allgather(ends), axis=0) * [[1], [-1]]
    relative: Floats = (2 * heights - (bottom + top)[bodies]) / (top - bottom)[bodies]
    return relative


def _matrix(
    comm: Any, starts: Integers, shares: Floats, width: int, motions: Floats, constrained: NDArray[np.int32]
) -> Any:
    """A matrix for displacements of nodes: three rows of each.

    Args:
        comm: ranks that share the nodes.
        starts: number of the first motion of the columns that each node stands between, shape (nodes, columns).
        shares: of the node in them, of the same shape.
        width: number of all motions.
        motions: displacement of the node by each of a column's, those of u, v and w in turn, shape (nodes, MOTIONS).
        constrained: dofs whose displacement is given: nothing there.
    """
    numbers = starts[:, None, :] + ORDER[:, None]
    values = motions[:, :, None] * shares[:, None, :]
    values *= ~np.isin(np.arange(3 * len(starts)), constrained).reshape(-1, 3)[:, AXES, None]
    share = np.broadcast_to(shares[:, None, :] > LEAST_SHARE, values.shape)
    lengths = share.sum(axis=(1, 2))[:, None] // MOTIONS * np.bincount(AXES)
    ends = np.append(0, np.cumsum(lengths))
    matrix = PETSc.Mat().createAIJ(
        ((len(ends) - 1, None), (None, width)),
        csr=(ends.astype(PETSc.IntType), numbers[share].astype(PETSc.IntType), values[share]),
        comm=comm,
    )
    matrix.assemble()
    return matrix
