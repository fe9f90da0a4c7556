"""The residual and the tangent: compiled forms and what contact adds beside them, summed over all ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.mesh import compat
from ncf_fenicsx.solver.equations import Integers, System
from ncf_fenicsx.solver.sparse_matrix import SparseMatrix

Floats = NDArray[np.float64]
ADD, REVERSE = PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE


class Residual:
    """Assembles a system's out-of-balance forces.

    Args:
        system: whose forces.

    Attributes:
        vector: PETSc vector that the last ones are in.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.vector: Any = compat.create_vector(system.displacement.function_space)

    def values(self) -> Floats:
        """Forces in N of all owned dofs at the present displacement, reactions included."""
        values: Floats = self.assemble(self.vector).array_r.copy()
        return values

    def assemble(self, b: Any) -> Any:
        """The same in a PETSc vector."""
        system = self.system
        with b.localForm() as local:
            local.set(0.0)
        system.contacts.refresh()
        fem_petsc.assemble_vector(b, system.residual_form)
        b.ghostUpdate(ADD, REVERSE)
        for nodes, values in system.contacts.residual():
            b.setValuesBlocked(nodes.astype(PETSc.IntType), values, ADD)
        b.assemble()
        return b


class TangentMatrix:
    """Assembles a system's tangent.

    Args:
        system: whose tangent.
        constrained: this rank's owned dofs whose displacement is given.
    """

    def __init__(self, system: System, constrained: Integers) -> None:
        self.system = system
        self._entries: Any = None
        self._nodes = system.displacement.function_space.dofmap.index_map
        self._free = self._unconstrained(constrained)
        self._links: Integers = np.zeros(0, dtype=np.int64)
        self._pairings = -1
        self.follow_links()
        self.follow_form()

    def _unconstrained(self, constrained: Integers) -> NDArray[np.bool_]:
        """Which dofs of the whole mesh are not constrained, by global node number, shape (nodes, 3)."""
        first, free = 3 * self._nodes.local_range[0], np.ones(3 * self._nodes.size_global, dtype=bool)
        free[np.concatenate(self._nodes.comm.allgather(first + constrained.astype(np.int64)))] = False
        return free.reshape(-1, 3)

    def follow_form(self) -> None:
        """Take the system's present form, which is compiled where it is new."""
        self._form = self.system.tangent_form

    def follow_links(self) -> bool:
        """Make a new matrix where contact couples nodes that the pattern does not; entries are never dropped.

        Returns:
            Whether the matrix is new.
        """
        contacts, space = self.system.contacts, self.system.displacement.function_space
        if contacts.pairings == self._pairings:
            return False
        self._pairings = contacts.pairings
        pairs = [self._links]
        for rows, columns in contacts.links():
            pairs.append((rows[:, :, None] * self._nodes.size_global + columns[:, None, :]).ravel())
        links = np.unique(np.concatenate(pairs))
        grown = self._nodes.comm.allreduce(len(links) > len(self._links))
        if self._entries is not None and not grown:
            return False
        self._links = links
        if self._entries is not None:
            self._entries.destroy()
            self._entries = None  # its memory goes before that of the next one comes
        self._entries = SparseMatrix(space, np.stack(np.divmod(links, self._nodes.size_global), axis=1))
        return True

    @property
    def matrix(self) -> Any:
        """PETSc's matrix; another object whenever the pattern has grown."""
        return self._entries.petsc

    def assemble(self) -> Any:
        """Tangent in N/m at the present displacement, rows and columns of constrained dofs those of the unit matrix."""
        system, A = self.system, self.matrix
        system.contacts.refresh()
        self._entries.assemble(self._form, system.supports.conditions)
        for rows, columns, blocks in system.contacts.tangent():
            free = [self._free[nodes].reshape(len(nodes), -1) for nodes in (rows, columns)]
            entries = blocks * free[0][:, :, None] * free[1][:, None, :]
            A.setValuesBlockedRCV(rows.astype(PETSc.IntType), columns.astype(PETSc.IntType), entries, ADD)
        A.assemble()
        return A
