"""Multigrid for a solid of one stiffness in all directions: no factors, so memory and time go with its unknowns.

Fibres a million times stiffer than what is between them are no case for it: smoothing one node after the other leaves
what they couple.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.solver.modes import LowestMode

PREFIX = "ncf_multigrid_"
OPTIONS = {"pc_gamg_reuse_interpolation": "true", "mg_levels_ksp_max_it": "1", "pc_gamg_threshold": "0.02"}
"""Aggregates of nodes stay as they are while the tangent changes, and follow strong links in flat cells; one smoothing
before and after the coarse solution, as twice costs more than it saves."""


class Multigrid:
    """Smoothed aggregation of a tangent (PETSc's GAMG), kept whatever becomes of it.

    Args:
        comm: ranks that share the tangent.
        positions: of this rank's owned nodes in m, shape (nodes, 3).
        constrained: its owned dofs whose displacement is given.

    Attributes:
        preconditioner: PETSc's, that applies it.
    """

    exact = has_pivots = False
    rough = 1e-3
    tolerance = 1e-5  # on graded meshes what it makes of a residual is too small

    def __init__(self, comm: Any, positions: NDArray[np.float64], constrained: NDArray[np.int32]) -> None:
        self._positions, self._constrained, self._mode = positions, constrained, LowestMode(constrained)
        self._motions: Any = None
        for name, value in OPTIONS.items():
            PETSc.Options()[PREFIX + name] = value
        self.preconditioner = PETSc.PC().create(comm)
        self.preconditioner.setOptionsPrefix(PREFIX)
        self.preconditioner.setType("gamg")
        self.preconditioner.setFromOptions()

    def factorise(self, matrix: Any) -> int:
        """Coarse tangents of a matrix; PETSc's reason why there are none, 0 if there are."""
        self._motions = self._motions or self._rigid_motions(matrix)
        matrix.setNearNullSpace(self._motions)
        self.preconditioner.setReusePreconditioner(False)
        self.preconditioner.setOperators(matrix)
        self.preconditioner.setUp()
        self.preconditioner.setReusePreconditioner(True)
        failed: int = self.preconditioner.getFailedReason()
        return failed

    def renew(self, matrix: Any) -> int:
        """Nothing: the hierarchy is kept as it is."""
        del matrix
        return 0

    def _rigid_motions(self, matrix: Any) -> Any:
        """What no stress resists, and no smoothing finds."""
        x, y, z = self._positions.T
        none, one = np.zeros_like(x), np.ones_like(x)
        turns = [(none, -z, y), (z, none, -x), (-y, x, none)]
        motions: list[Any] = []
        for motion in [(one, none, none), (none, one, none), (none, none, one), *turns]:
            vector = matrix.createVecRight()
            vector.array[:] = np.stack(motion, axis=1).ravel()
            vector.array[self._constrained] = 0.0
            for other in motions:
                vector.axpy(-vector.dot(other), other)
            vector.normalize()
            motions.append(vector)
        return PETSc.NullSpace().create(vectors=motions, comm=matrix.comm)

    def forget(self) -> None:
        """Forget all, the aggregates included."""
        self.preconditioner.reset()

    def count_negative(self, matrix: Any) -> int:
        """One where a mode of negative stiffness is found: see `LowestMode`."""
        return int(self._mode.curvature(matrix, self.preconditioner.apply) < 0)
