"""Solves with the tangent: by its factors, or by GMRES with the factors of an earlier one."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

LARGE = 50_000
"""Unknowns from which on a few Krylov steps cost less than factors."""
TOLERANCE = 1e-4
"""What old factors make of a correction's residual, over the correction: as exact as a Newton step needs to be.

Over what they make of the load itself, as is usual, says nothing: where contact has closed, that is far off.
"""
MOST = 25
"""Krylov steps after which factors cost less."""
SLOW = 15
"""Krylov steps after which the next correction had better have factors of its own."""
OPTIONS = {
    "ncf_mat_mumps_icntl_14": 60,  # per cent of spare workspace: pivoting of an indefinite tangent needs it
}


class LinearSolver:
    """MUMPS's LDL^T or LU, kept over iterations and steps as long as GMRES converges fast with it.

    Contact that opens or closes changes the tangent at few nodes, so old factors are a good preconditioner: in place of
    a factorisation, some solutions with factors at hand. But the pivots that tell of a loss of stability are
    those of a step's own factors. So the correction that is taken to be the last of a step has new ones.

    Args:
        comm: ranks that share the matrix.
        symmetric: LDL^T if so, else LU.
        keeps: whether factors are kept.

    Attributes:
        factorised: whether there are factors, of this tangent or an earlier one.
        factorisations: so far.
        krylov_steps: of GMRES so far.
    """

    def __init__(self, comm: Any, symmetric: bool, keeps: bool) -> None:
        self.keeps, self.factorisations, self.krylov_steps = keeps, 0, 0
        for name, value in OPTIONS.items():
            PETSc.Options()[name] = value
        self._direct, self._krylov = PETSc.KSP().create(comm), PETSc.KSP().create(comm)
        self._direct.setOptionsPrefix("ncf_")
        self._direct.setType("preonly")
        self.factors = self._direct.getPC()
        self.factors.setType("cholesky" if symmetric else "lu")
        self.factors.setFactorSolverType("mumps")
        self._direct.setFromOptions()
        self._krylov.setType("gmres")
        self._krylov.setGMRESRestart(MOST)
        self._krylov.setConvergenceTest(self._judge)
        self._krylov.setPC(self.factors)
        self.factorised = self._fresh = self._slow = self._renewed = self._renewed_before = False
        self._renew = True
        self._correction: Any = None

    def begin(self) -> None:
        """Begin a nonlinear solve."""
        self._renewed_before, self._renewed = self._renewed, False

    def expect(self, last: bool, exact: bool) -> None:
        """Before a correction.

        Args:
            last: whether it is taken to be the last of its nonlinear solve.
            exact: whether more is to be solved with the same tangent.
        """
        due = not self._renewed and (last or not self._renewed_before)
        self._renew = exact or due or self._slow or not self.keeps

    def forget(self) -> None:
        """Forget all factors, the order of elimination included."""
        self._krylov.reset()
        self._direct.reset()
        self.factorised = self._fresh = False

    def factorise(self, matrix: Any) -> int:
        """New factors; PETSc's reason why there are none, 0 if there are."""
        self.factors.setReusePreconditioner(False)
        self._direct.setOperators(matrix)
        self._direct.setUp()
        self.factorisations += 1
        self._slow, self._renewed, self._fresh = False, True, True
        failed: int = self.factors.getFailedReason()
        self.factorised = not failed
        return failed

    def setUp(self, outer: Any) -> None:
        """Told by PETSc that the matrix has changed."""
        del outer
        self._fresh = False

    def apply(self, outer: Any, b: Any, x: Any) -> None:
        """Solve A x = b with the outer preconditioner's matrix A."""
        matrix = outer.getOperators()[0]
        if not self._fresh:
            if self.factorised and not self._renew and self._iterate(matrix, b, x):
                return
            outer.setFailedReason(self.factorise(matrix))
        self._direct.solve(b, x)

    def _judge(self, krylov: Any, step: int, norm: float) -> Any:
        """Whether GMRES has converged, given the norm in m of the residual with the factors applied to it."""
        reasons = PETSc.KSP.ConvergedReason
        krylov.buildSolution(self._correction)
        if norm <= TOLERANCE * self._correction.norm():
            return reasons.CONVERGED_RTOL
        return reasons.DIVERGED_MAX_IT if step >= MOST else reasons.ITERATING

    def _iterate(self, matrix: Any, b: Any, x: Any) -> bool:
        """Whether GMRES converges fast with the factors at hand."""
        self._correction = self._correction or x.duplicate()
        self.factors.setReusePreconditioner(True)
        self._krylov.setOperators(matrix)
        self._krylov.solve(b, x)
        steps = self._krylov.getIterationNumber()
        self.krylov_steps += steps
        self._slow = steps > SLOW
        return bool(self._krylov.getConvergedReason() > 0)
