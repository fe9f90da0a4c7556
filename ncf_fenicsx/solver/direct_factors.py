"""Factors of a whole matrix: MUMPS's LDL^T or LU."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

SPARE = 60
"""Per cent of spare workspace (ICNTL(14)): pivoting of an indefinite tangent needs it."""
SHARED = 10
"""Loads are handed over by each rank for itself (ICNTL(20)): a sixth faster than by the first one for all."""
NEGATIVE_PIVOTS = 12
"""Where MUMPS tells their number: INFOG(12)."""


class DirectFactors:
    """Factors of a matrix, exact to round-off.

    Args:
        comm: ranks that share the matrix.
        symmetric: LDL^T if so, else LU.
        prefix: of PETSc's options.

    Attributes:
        preconditioner: PETSc's, that applies them.
    """

    exact, lasts = True, False
    rough = 1e-3
    tolerance = 1e-4

    def __init__(self, comm: Any, symmetric: bool, prefix: str = "ncf_") -> None:
        options = PETSc.Options()
        options[f"{prefix}mat_mumps_icntl_14"] = SPARE
        if comm.size > 1:
            options[f"{prefix}mat_mumps_icntl_20"] = SHARED
        self._solver = PETSc.KSP().create(comm)
        self._solver.setOptionsPrefix(prefix)
        self._solver.setType("preonly")
        self.preconditioner = self._solver.getPC()
        self.preconditioner.setType("cholesky" if symmetric else "lu")
        self.preconditioner.setFactorSolverType("mumps")
        self._solver.setFromOptions()

    def factorise(self, matrix: Any) -> int:
        """Factors of a matrix, kept whatever becomes of it; PETSc's reason why there are none, 0 if there are."""
        self.preconditioner.setReusePreconditioner(False)
        self._solver.setOperators(matrix)
        self._solver.setUp()
        self.preconditioner.setReusePreconditioner(True)
        failed: int = self.preconditioner.getFailedReason()
        return failed

    def renew(self, matrix: Any) -> int:
        """Nothing: all is one."""
        del matrix
        return 0

    def solve(self, b: Any, x: Any) -> None:
        """Solve for x with the factors at hand."""
        self._solver.solve(b, x)

    def forget(self) -> None:
        """Forget all, the order of elimination included."""
        self._solver.reset()

    def count_negative(self, matrix: Any) -> int:
        """Negative pivots, with LDL^T: as many as the matrix that they are of has negative eigenvalues."""
        del matrix
        return int(self.preconditioner.getFactorMatrix().getMumpsInfog(NEGATIVE_PIVOTS))
