"""A matrix that DOLFINx sums integrals into and PETSc solves with: PETSc's own summation takes as long as the laws."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.mesh import compat

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class SparseMatrix:
    """Entries for integrals over the cells of a space and for further pairs of nodes; entries are never dropped.

    On one rank, DOLFINx and PETSc have the same values in memory. On several, the columns of other ranks stand apart in
    PETSc, so that values are copied.

    Args:
        space: of nodal fields.
        links: global numbers of the nodes of rows and columns, shape (pairs, 2); they may belong to other ranks.

    Attributes:
        petsc: PETSc's matrix, of blocks of three by three.
    """

    def __init__(self, space: Any, links: Integers) -> None:
        self._summed = compat.create_matrix(space, links)
        numbering = self._summed.index_map(1)
        starts = self._summed.indptr[: numbering.size_local + 1]
        columns, self._values = self._summed.indices[: starts[-1]], self._summed.data[: starts[-1]]
        comm = space.dofmap.index_map.comm  # that of PETSc's vectors: ranks free together what is on one communicator
        self._runs: list[slice] = []
        if comm.size == 1:
            parts: Any = _index(starts), _index(columns), self._values
        else:
            parts = self._apart(starts, columns, numbering)
        size = numbering.size_local, numbering.size_global
        self.petsc: Any = PETSc.Mat().createAIJWithArrays((size, size), parts, comm=comm)
        self.petsc.setBlockSize(space.dofmap.index_map_bs)

    def _apart(self, starts: Integers, columns: NDArray[np.int32], numbering: Any) -> tuple[Any, Any]:
        """First entries of rows, columns and values of the own columns, and of those of other ranks.

        Own ones are copied run by run: an index of each would take as much memory as the values. PETSc wants those of
        other ranks in the order of their global numbers.
        """
        own = columns < numbering.size_local
        ends = np.flatnonzero(np.diff(own, prepend=False, append=False)).reshape(-1, 2)
        self._runs, self._inner = [slice(*pair) for pair in ends], np.zeros(np.count_nonzero(own))
        inner = _index(_counted(own)[starts]), _index(columns[own]), self._inner
        places = np.flatnonzero(~own)
        rows, numbers = np.searchsorted(starts, places, side="right"), numbering.local_to_global(columns[places])
        order = np.lexsort((numbers, rows))
        self._places, self._outer = places[order], np.zeros(len(order))
        return inner, (_index(_counted(~own)[starts]), _index(numbers[order]), self._outer)

    def assemble(self, form: Any, conditions: list[Any]) -> None:
        """Take the values of a compiled bilinear form; rows and columns of constrained dofs those of the unit matrix.

        Args:
            form: over the cells of the space and their outer facets; DOLFINx does not check that its entries have room.
            conditions: homogeneous Dirichlet conditions.
        """
        self.petsc.zeroEntries()  # so that PETSc knows, too, that they change
        self._summed.set_value(0.0)
        fem.assemble_matrix(self._summed, form, conditions)
        self._summed.scatter_reverse()
        if self._runs:
            self._copy()

    def _copy(self) -> None:
        """Hand PETSc the values of this rank."""
        first = 0
        for run in self._runs:
            last = first + run.stop - run.start
            self._inner[first:last] = self._values[run]
            first = last
        self._outer[:] = self._values[self._places]

    def destroy(self) -> None:
        """Free what PETSc has made of it, on all ranks together."""
        self.petsc.destroy()


def _index(numbers: NDArray[Any]) -> NDArray[Any]:
    """Numbers as PETSc stores them."""
    return np.ascontiguousarray(numbers, dtype=PETSc.IntType)


def _counted(chosen: NDArray[np.bool_]) -> Integers:
    """How many are chosen before each place, and in all."""
    return np.concatenate([[0], np.cumsum(chosen)])
