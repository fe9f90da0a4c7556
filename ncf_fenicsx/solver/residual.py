"""The residual: compiled forms and what contact adds beside them, summed over all ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.solver.equations import System

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
        self.vector: Any = fem_petsc.create_vector(system.residual_form)

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
