"""What all layers of a stack do alike: a coarse space for its tangent.

Layers in contact bend together: all nodes of a column move alike, and the layers turn alike. No layer by itself shows
how soft that is, nor do all heights without the turns. These are few unknowns, so their factors cost next to nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.grid_lines import places
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.galerkin import galerkin

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOTIONS = 5
"""Of a column: three displacements, and two turns."""


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
        None where nodes of the layers do not stand above each other, so that there are no columns.
    """
    ranks = comm.tompi4py()
    column, count = _columns(ranks, positions[:, :2])
    if ranks.allreduce(len(column)) < 2 * layers * count:
        return None
    height = _heights_in_layers(ranks, positions[:, 2], sublaminates, layers)
    return _matrix(comm, MOTIONS * column, MOTIONS * count, height, constrained)


def _columns(ranks: MPI.Comm, plan: Floats) -> tuple[Integers, int]:
    """Column of each owned node, numbered alike on any number of ranks, and the number of columns."""
    parts = ranks.allgather(plan)
    everywhere = np.concatenate(parts)
    column = places(everywhere, float(np.ptp(everywhere, axis=0).max()))
    first = sum(len(part) for part in parts[: ranks.rank])
    return column[first : first + len(plan)], int(column.max()) + 1


def _heights_in_layers(ranks: MPI.Comm, heights: Floats, sublaminates: Integers, count: int) -> Floats:
    """Height of each owned node in its sublaminate, from -1 at the bottom to 1 at the top."""
    ends = np.full((2, count), np.inf)
    for side, values in zip(ends, (heights, -heights), strict=True):
        np.minimum.at(side, sublaminates, values)
    bottom, top = np.min(ranks.allgather(ends), axis=0) * [[1], [-1]]
    within: Floats = (2 * heights - (bottom + top)[sublaminates]) / (top - bottom)[sublaminates]
    return within


def _matrix(comm: Any, own: Integers, width: int, height: Floats, constrained: NDArray[np.int32]) -> Any:
    """Rows u and v: a displacement, and a turn by the height; row w: a displacement. Nothing where it is given."""
    one = np.ones(len(own))
    numbers = np.stack([own, own + 3, own + 1, own + 4, own + 2], axis=1)
    shares = np.stack([one, height, one, height, one], axis=1)
    ends = np.append(0, (MOTIONS * np.arange(len(own))[:, None] + [2, 4, 5]).ravel())
    rows = np.repeat(np.arange(3 * len(own)), np.diff(ends))
    values = np.where(np.isin(rows, constrained), 0.0, shares.ravel())
    matrix = PETSc.Mat().createAIJ(
        ((3 * len(own), None), (None, width)),
        csr=(ends.astype(PETSc.IntType), numbers.ravel().astype(PETSc.IntType), values),
        comm=comm,
    )
    matrix.assemble()
    return matrix
