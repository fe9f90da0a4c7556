"""A matrix that DOLFINx sums integrals into and PETSc solves with: PETSc's own summation takes as long as the laws."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.mesh import compat

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class SparseMatrix:
    """Entries for integrals over the cells of a space and for further pairs of nodes; entries are never dropped.

    On one rank, DOLFINx and PETSc have the same entries in memory. On several, the columns of other ranks stand apart
    in PETSc, so that entries are copied.

    Args:
        space: of nodal fields.
        links: global numbers of the nodes of rows and columns, shape (pairs, 2); nodes of other ranks are welcome.
        constrained: this rank's owned dofs whose rows and columns are those of the unit matrix.

    Attributes:
        petsc: PETSc's matrix, of blocks of three by three.
    """

    def __init__(self, space: Any, links: Integers, constrained: Integers) -> None:
        self._sums = compat.create_matrix(space, links)
        columns = self._sums.index_map(1)
        comm = space.dofmap.index_map.comm  # that of PETSc's vectors: ranks free together what is on one communicator
        self._own = columns.size_local
        starts = self._sums.indptr[: self._own + 1]
        numbers, self._values = self._sums.indices[: starts[-1]], self._sums.data[: starts[-1]]
        rows = ((dof, slice(*starts[dof : dof + 2])) for dof in constrained)
        self._units = [row.start + np.searchsorted(numbers[row], dof) for dof, row in rows]
        self._copies: list[tuple[Floats, Floats]] = []
        self._places: Integers = np.zeros(0, dtype=np.int64)
        self._others: Floats = np.zeros(0)
        if comm.size == 1:
            parts: Any = _index(starts), _index(numbers), self._values
        else:
            parts = self._inner(starts, numbers), self._outer(starts, numbers, columns)
        size = self._own, columns.size_global
        self.petsc: Any = PETSc.Mat().createAIJWithArrays((size, size), parts, comm=comm)
        self.petsc.setBlockSize(space.dofmap.index_map_bs)
        self.petsc.setOption(PETSc.Mat.Option.NO_OFF_PROC_ENTRIES, False)

    def _inner(self, starts: Integers, numbers: NDArray[np.int32]) -> tuple[Any, Any, Floats]:
        """First entries of rows, columns and values of the block of own columns."""
        inner = numbers < self._own
        values, first = np.zeros(np.count_nonzero(inner)), 0
        for start, end in np.flatnonzero(np.diff(inner, prepend=False, append=False)).reshape(-1, 2):
            last = first + end - start
            self._copies.append((values[first:last], self._values[start:end]))
            first = last
        return _index(_counted(inner)[starts]), _index(numbers[inner]), values

    def _outer(self, starts: Integers, numbers: NDArray[np.int32], columns: Any) -> tuple[Any, Any, Floats]:
        """The same of the columns of other ranks, by their global numbers, which PETSc takes in order."""
        outer = numbers >= self._own
        self._places = np.flatnonzero(outer)
        rows, names = np.searchsorted(starts, self._places, side="right"), columns.local_to_global(numbers[outer])
        order = np.lexsort((names, rows))
        self._places, self._others = self._places[order], np.zeros(len(order))
        return _index(_counted(outer)[starts]), _index(names[order]), self._others

    def assemble(self, form: Any, conditions: list[Any]) -> None:
        """Take the values of a compiled bilinear form.

        Args:
            form: over the cells of the space and their facets.
            conditions: homogeneous Dirichlet conditions, which constrain the dofs.
        """
        self.petsc.zeroEntries()
        self._sums.set_value(0.0)
        compat.assemble_matrix(self._sums, form, conditions)
        self._values[self._units] = 1.0
        for values, sums in self._copies:
            values[:] = sums
        self._others[:] = self._values[self._places]

    def destroy(self) -> None:
        """Free PETSc's memory, on all ranks together."""
        self.petsc.destroy()


def _index(numbers: NDArray[Any]) -> NDArray[Any]:
    """Numbers as PETSc stores them."""
    return np.ascontiguousarray(numbers, dtype=PETSc.IntType)


def _counted(chosen: NDArray[np.bool_]) -> Integers:
    """How many are chosen before each one, and of all."""
    return np.concatenate([[0], np.cumsum(chosen)])
