"""Multigrid for a solid of one stiffness in all directions: no factors, so memory and time go with its unknowns.

Fibres a million times stiffer than what is between them are no case for it: smoothing one node after the other leaves
what they couple.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.solver.galerkin import galerkin
from ncf_fenicsx.solver.grid_levels import grid_of, motions_of_grids
from ncf_fenicsx.solver.modes import LowestMode

PREFIX = "ncf_multigrid_"
OPTIONS = {"pc_gamg_reuse_interpolation": "true", "mg_levels_ksp_max_it": "1", "pc_gamg_threshold": "0.02"}
"""Aggregates of nodes stay as they are while the tangent changes, and follow strong links in flat cells; one smoothing
before and after the coarse solution, as twice costs more than it saves."""


class Multigrid(ABC):
    """Coarse tangents that a tangent's approximate inverse is made of, kept whatever becomes of it.

    Args:
        comm: ranks that share the tangent.
        constrained: this rank's owned dofs whose displacement is given.
        way: PETSc's name of it.

    Attributes:
        preconditioner: PETSc's, that applies the approximate inverse.
    """

    exact = False
    lasts: bool
    rough: float
    tolerance: float

    def __init__(self, comm: Any, constrained: NDArray[np.int32], way: str) -> None:
        self._mode = LowestMode(constrained)
        self.preconditioner = PETSc.PC().create(comm)
        self.preconditioner.setType(way)

    def factorise(self, matrix: Any) -> int:
        """Coarse tangents of a matrix; PETSc's reason why there are none, 0 if there are."""
        self.preconditioner.setReusePreconditioner(False)
        self._coarsen(matrix)
        self.preconditioner.setUp()
        self.preconditioner.setReusePreconditioner(True)
        failed: int = self.preconditioner.getFailedReason()
        return failed

    @abstractmethod
    def _coarsen(self, matrix: Any) -> None:
        """Hand the matrix to PETSc, with what its coarse tangents come from."""

    def renew(self, matrix: Any) -> int:
        """Nothing: the hierarchy is kept as it is."""
        del matrix
        return 0

    def forget(self) -> None:
        """Forget all that follows from the pattern of a matrix."""
        self.preconditioner.reset()

    def count_negative(self, matrix: Any) -> int:
        """One where a mode of negative stiffness is found: see `LowestMode`."""
        return int(self._mode.curvature(matrix, self.preconditioner.apply) < 0)


class GridMultigrid(Multigrid):
    """Galerkin's tangents on coarser grids.

    Args:
        comm: ranks that share the tangent.
        constrained: this rank's owned dofs whose displacement is given.
        motions: from `motions_of_grids`.
    """

    lasts = False
    rough = 1e-3
    tolerance = 1e-4

    def __init__(self, comm: Any, constrained: NDArray[np.int32], motions: list[Any]) -> None:
        super().__init__(comm, constrained, "mg")
        self._motions: list[Any] = motions
        self._tangents: list[Any] = [None] * len(motions)
        self.preconditioner.setMGLevels(len(motions) + 1)  # in PETSc's order, the coarsest first
        self._link_grids()
        for level in range(1, len(motions) + 1):
            smoother = self.preconditioner.getMGSmoother(level)
            smoother.setType("richardson")
            smoother.setTolerances(max_it=1)
            smoother.getPC().setType("sor")  # forth and back over a rank's nodes, so that the inverse is symmetric
        self._coarsest = self.preconditioner.getMGCoarseSolve()
        self._coarsest.setType("preonly")
        self._coarsest.getPC().setType("cholesky")
        self._coarsest.getPC().setFactorSolverType("mumps")

    def _link_grids(self) -> None:
        for level, motions in enumerate(reversed(self._motions), 1):
            self.preconditioner.setMGInterpolation(level, motions)

    def _coarsen(self, matrix: Any) -> None:
        tangents = [matrix]
        for motions, before in zip(self._motions, self._tangents, strict=True):
            tangents.append(galerkin(tangents[-1], motions, before))
        self._tangents = tangents[1:]
        self.preconditioner.setOperators(matrix)
        for level, tangent in enumerate(reversed(tangents[:-1]), 1):
            self.preconditioner.getMGSmoother(level).setOperators(tangent)
        self._coarsest.setOperators(tangents[-1])

    def forget(self) -> None:
        """Forget the coarse tangents; PETSc drops the links of the grids with them."""
        super().forget()
        self._link_grids()
        self._tangents = [None] * len(self._motions)


class AggregateMultigrid(Multigrid):
    """Smoothed aggregation with the rigid motions (PETSc's GAMG).

    Args:
        comm: ranks that share the tangent.
        constrained: this rank's owned dofs whose displacement is given.
        positions: of its owned nodes in m, shape (nodes, 3).
    """

    lasts = True
    rough = 1e-3
    tolerance = 1e-5  # on graded meshes what it makes of a residual is too small

    def __init__(self, comm: Any, constrained: NDArray[np.int32], positions: NDArray[np.float64]) -> None:
        super().__init__(comm, constrained, "gamg")
        for name, value in OPTIONS.items():
            PETSc.Options()[PREFIX + name] = value
        self.preconditioner.setOptionsPrefix(PREFIX)
        self.preconditioner.setFromOptions()
        self._positions, self._constrained = positions, constrained
        self._motions: Any = None

    def _coarsen(self, matrix: Any) -> None:
        self._motions = self._motions or self._rigid_motions(matrix)
        matrix.setNearNullSpace(self._motions)
        self.preconditioner.setOperators(matrix)

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


def multigrid(
    comm: Any, positions: NDArray[np.float64], sublaminates: NDArray[np.int64], constrained: NDArray[np.int32]
) -> Multigrid:
    """On coarser grids where nodes stand on the lines of one, else by aggregates of nodes.

    Args:
        comm: ranks that share the tangent.
        positions: of this rank's owned nodes in m, shape (nodes, 3).
        sublaminates: number of the body that each of these nodes belongs to.
        constrained: its owned dofs whose displacement is given.
    """
    grid = grid_of(comm.tompi4py(), positions, sublaminates, constrained)
    if grid is None:
        return AggregateMultigrid(comm, constrained, positions)
    return GridMultigrid(comm, constrained, motions_of_grids(comm, grid))
