"""The mode in which a state loses stability: eigenvector of the tangent's lowest eigenvalue."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from ncf_fenicsx.solver.direct_factors import DirectFactors

HELD = 1e6
"""Stiffness of held dofs over the largest on the diagonal: their eigenvalues are far from the lowest."""
FIRST_SHIFT = 1e-12
"""First shift over the largest stiffness on the diagonal."""


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
    solves = transform.getKSP()
    solves.setType("preonly")
    solves.getPC().setType("cholesky")
    solves.getPC().setFactorSolverType("mumps")
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
        factors = DirectFactors(matrix.getComm(), symmetric=True)
        factors.factorise(shifted)
        if not factors.count_negative(shifted):
            return shift
        shift *= 4
