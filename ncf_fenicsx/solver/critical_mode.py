"""The mode in which a state loses stability: eigenvector of the tangent's lowest eigenvalue."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

HELD = 1e6
"""Stiffness of held dofs over the largest on the diagonal: their eigenvalues are far from the lowest."""
FIRST_SHIFT = 1e-12
"""First shift over the largest stiffness on the diagonal."""
NEGATIVE_PIVOTS = 12
"""Where MUMPS tells their number: INFOG(12)."""


def negative_pivots(factors: Any) -> int:
    """Negative pivots in MUMPS's LDL^T factors: as many as the matrix has negative eigenvalues."""
    return int(factors.getFactorMatrix().getMumpsInfog(NEGATIVE_PIVOTS))


def critical_mode(matrix: Any, held: NDArray[np.int32]) -> tuple[float, Any] | None:
    """Lowest eigenvalue in N/m of a symmetric tangent and its eigenvector.

    Shifts grow until the shifted tangent has no negative pivot: then no eigenvalue is nearer to it than the lowest.

    Args:
        matrix: the tangent; the diagonal of its held dofs is changed.
        held: owned local dofs whose displacement is given.

    Returns:
        None if the eigenvalue solver did not converge.
    """
    diagonal = matrix.getDiagonal()
    largest = diagonal.norm(PETSc.NormType.NORM_INFINITY)
    diagonal.array[held] = HELD * largest
    matrix.setDiagonal(diagonal)
    solver = SLEPc.EPS().create(matrix.getComm())
    solver.setOperators(matrix)
    solver.setProblemType(SLEPc.EPS.ProblemType.HEP)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    _direct(transform.getKSP())
    solver.setTarget(-_shift_below(matrix, FIRST_SHIFT * largest))
    solver.solve()
    if not solver.getConverged():
        return None
    vector = matrix.createVecRight()
    value = solver.getEigenpair(0, vector)
    return float(value.real), vector


def _shift_below(matrix: Any, shift: float) -> float:
    """A shift in N/m, some times a first one, that makes the matrix positive definite."""
    while True:
        shifted = matrix.copy()
        shifted.shift(shift)
        solver = PETSc.KSP().create(matrix.getComm())
        solver.setOperators(shifted)
        _direct(solver)
        solver.setUp()
        if negative_pivots(solver.getPC()) == 0:
            return shift
        shift *= 4


def _direct(solver: Any) -> None:
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
