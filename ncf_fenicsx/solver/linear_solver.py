"""Solves with the tangent: by its factors, or by GMRES with those of an earlier one or its parts, or multigrid."""

from __future__ import annotations

from typing import Any, Protocol

from petsc4py import PETSc

MOST = 25
"""Krylov steps after which new factors cost less."""
SLOW = 15
"""Krylov steps after which the next correction had better have factors of its own."""
SLOWER = 3
"""The same over the steps with factors of its own, where these are not exact."""
MOST_OF_NEW = 150
"""Krylov steps after which factors that are new but not exact are no good."""


class Factors(Protocol):
    """Something like the inverse of a matrix.

    What they make of a residual is held against the correction: over what they make of the load itself, as is usual, it
    says nothing, for where contact has closed, that is far off.

    Attributes:
        exact: whether it is the inverse.
        lasts: whether they are so dear that they are kept from one nonlinear solve to the next.
        rough: what they make of a correction's residual, over the correction: exact enough for one that others follow.
        tolerance: the same for a correction that is taken to be the last of its solve.
        preconditioner: PETSc's, that applies it.
    """

    exact: bool
    lasts: bool
    rough: float
    tolerance: float
    preconditioner: Any

    def factorise(self, matrix: Any) -> int:
        """Factors of a matrix, kept whatever becomes of it; PETSc's reason why there are none, 0 if there are."""

    def renew(self, matrix: Any) -> int:
        """Make factors that are kept follow a matrix, as far as that is cheap; PETSc's reason why not, 0 if so."""

    def forget(self) -> None:
        """Forget all, the order of elimination included."""

    def count_negative(self, matrix: Any) -> int:
        """Negative eigenvalues of the symmetric matrix, no more than it has."""


class LinearSolver:
    """Factors, kept over the iterations of a solve as long as GMRES converges fast with them.

    Contact that opens or closes changes the tangent at few nodes, so old factors are a good preconditioner: in place of
    a factorisation, some solutions with factors at hand. A solve's first correction has new ones, so that a run that
    goes on from a checkpoint takes the same path as one that never stopped; multigrid that is dear is kept over steps,
    too. The pivots that tell of a loss of stability are those of factors of the whole: the correction that is taken to
    be the last of a step has its own.

    Args:
        factors: of the tangent.
        keeps: whether they are kept.

    Attributes:
        factorised: whether there are factors, of this tangent or an earlier one.
        factorisations: so far.
        krylov_steps: of GMRES so far.
    """

    def __init__(self, factors: Factors, keeps: bool) -> None:
        self.factors, self.keeps, self.factorisations, self.krylov_steps = factors, keeps, 0, 0
        self._most, self._tolerance = MOST if factors.exact else MOST_OF_NEW, factors.tolerance
        self._krylov = PETSc.KSP().create(factors.preconditioner.comm)
        self._krylov.setType("gmres")
        self._krylov.setGMRESRestart(self._most)
        self._krylov.setConvergenceTest(self._judge)
        self._krylov.setPC(factors.preconditioner)
        self.factorised = self._fresh = self._slow = self._first = self._told = self._follows = False
        self._renew, self._steps_of_new = True, 0
        self._correction: Any = None

    def begin(self) -> None:
        """Begin a nonlinear solve."""
        self._first, self._told = True, False

    def expect(self, last: bool, exact: bool) -> None:
        """Before a correction.

        Args:
            last: whether it is taken to be the last of its nonlinear solve.
            exact: whether more is to be solved with the same tangent.
        """
        self._tolerance = self.factors.tolerance if last or exact else self.factors.rough
        begins = self._first and not self.factors.lasts
        tells = last and self.factors.exact and not self._told
        self._renew = exact or begins or tells or self._slow or not self.keeps
        self._first, self._told = False, self._told or tells

    def forget(self) -> None:
        """Forget all factors, the order of elimination included."""
        self._krylov.reset()
        self.factors.forget()
        self.factorised = self._fresh = False

    def factorise(self, matrix: Any) -> int:
        """New factors; PETSc's reason why there are none, 0 if there are."""
        failed = self.factors.factorise(matrix)
        self.factorisations += 1
        self._slow, self._fresh = False, True
        self.factorised = not failed
        return failed

    def setUp(self, outer: Any) -> None:
        """Told by PETSc that the matrix has changed."""
        del outer
        self._fresh = self._follows = False

    def apply(self, outer: Any, b: Any, x: Any) -> None:
        """Solve A x = b with the outer preconditioner's matrix A."""
        matrix = outer.getOperators()[0]
        if not self._fresh:
            if self.factorised and not self._renew and self._follow(matrix) and self._iterate(matrix, b, x):
                return
            outer.setFailedReason(self.factorise(matrix))
        if self.factors.exact or not self.factorised:
            self.factors.preconditioner.apply(b, x)
        elif not self._iterate(matrix, b, x):
            outer.setFailedReason(PETSc.PC.FailedReason.SUBPC_ERROR)

    def _follow(self, matrix: Any) -> bool:
        """Whether factors that are kept could follow the matrix."""
        self._follows = self._follows or not self.factors.renew(matrix)
        return self._follows

    def _judge(self, krylov: Any, step: int, norm: float) -> Any:
        """Whether GMRES has converged, given the norm in m of the residual with the factors applied to it."""
        reasons = PETSc.KSP.ConvergedReason
        krylov.buildSolution(self._correction)
        if norm <= self._tolerance * self._correction.norm():
            return reasons.CONVERGED_RTOL
        return reasons.DIVERGED_MAX_IT if step >= self._most else reasons.ITERATING

    def _iterate(self, matrix: Any, b: Any, x: Any) -> bool:
        """Whether GMRES converges fast with the factors at hand."""
        self._correction = self._correction or x.duplicate()
        self._krylov.setOperators(matrix)
        self._krylov.solve(b, x)
        steps = self._krylov.getIterationNumber()
        self.krylov_steps += steps
        self._steps_of_new = steps if self._fresh else self._steps_of_new
        self._slow = steps > max(SLOW, SLOWER * self._steps_of_new)
        return bool(self._krylov.getConvergedReason() > 0)
