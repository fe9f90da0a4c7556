"""Modes of lowest stiffness: the one in which a state loses stability, and a search that needs no factors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from ncf_fenicsx.solver.direct_factors import DirectFactors

CONSTRAINED = 1e6
"""Stiffness of constrained dofs over the largest on the diagonal: their eigenvalues are far from the lowest."""
FIRST_SHIFT = 1e-12
"""First shift over the largest stiffness on the diagonal."""


Pair = tuple[Any, Any]
"""A vector, and the matrix times it."""
STEPS = 8
"""Improvements at a time, at most: the matrix changes little from step to step, so the mode improves over many."""
SETTLED = 0.03
"""Share of its stiffness below which an improvement is the last for now."""
DISTINCT = 1e-6
"""Length, of a direction of length one, across those before it that is more than round-off."""


def critical_mode(matrix: Any, constrained: NDArray[np.int32]) -> tuple[float, Any] | None:
    """Lowest eigenvalue in N/m of a symmetric tangent and its eigenvector.

    Shifts grow until the shifted tangent has no negative pivot: then no eigenvalue is nearer to it than the lowest.

    Args:
        matrix: the tangent; the diagonal of its constrained dofs is changed.
        constrained: owned local dofs whose displacement is given.

    Returns:
        None if the eigenvalue solver did not converge.
    """
    diagonal = matrix.getDiagonal()
    largest = diagonal.norm(PETSc.NormType.NORM_INFINITY)
    diagonal.array[constrained] = CONSTRAINED * largest
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


class LowestMode:
    """A vector with a low Rayleigh quotient, improved by locally optimal conjugate gradients (Knyazev 2001).

    Args:
        constrained: owned local dofs whose displacement is given; their rows are those of the unit matrix.
    """

    def __init__(self, constrained: NDArray[np.int32]) -> None:
        self._constrained = constrained
        self._mode: Any = None

    def curvature(self, matrix: Any, precondition: Callable[[Any, Any], None]) -> float:
        """Rayleigh quotient in N/m after some improvements; no more of them once it is negative or settled.

        Args:
            matrix: symmetric.
            precondition: writes the approximate inverse times its first argument into the second.
        """
        if self._mode is None:
            self._mode = self._start(matrix)
        mode, directions, before = _pair(matrix, self._mode), list[Pair](), np.inf
        for _ in range(STEPS):
            mode = _scaled(mode)
            quotient = mode[0].dot(mode[1])
            if quotient < 0 or quotient > (1 - SETTLED) * before:
                break
            before = quotient
            residual, downhill = mode[1].copy(), mode[1].duplicate()
            residual.axpy(-quotient, mode[0])
            precondition(residual, downhill)
            basis = _orthonormal([mode, _pair(matrix, downhill), *directions])
            if len(basis) < 2:  # it is an eigenvector, or nothing is a number
                break
            shares = _lowest(basis)
            directions = [_sum(basis[1:], shares[1:])]
            mode = _sum(basis, shares)
        vector, image = _scaled(_pair(matrix, mode[0]))  # anew: round-off of the sums is no proof
        quotient = float(vector.dot(image))
        self._mode = vector if np.isfinite(quotient) else None
        return quotient

    def _start(self, matrix: Any) -> Any:
        """Numbers without order."""
        start = matrix.createVecRight()
        start.array[:] = np.sin(np.arange(*start.getOwnershipRange()) ** 2 % 97 + 1.0)
        start.array[self._constrained] = 0.0
        return start


def _pair(matrix: Any, vector: Any) -> Pair:
    image = vector.duplicate()
    matrix.mult(vector, image)
    return vector, image


def _scaled(pair: Pair) -> Pair:
    length = pair[0].norm()
    for vector in pair:
        vector.scale(1.0 / length if length else 0.0)
    return pair


def _orthonormal(pairs: list[Pair]) -> list[Pair]:
    """Gram and Schmidt, without directions that are none."""
    basis: list[Pair] = []
    for vector, image in map(_scaled, pairs):
        for other, other_image in basis * 2:  # twice is enough
            share = vector.dot(other)
            vector.axpy(-share, other)
            image.axpy(-share, other_image)
        if vector.norm() > DISTINCT:
            basis.append(_scaled((vector, image)))
    return basis


def _lowest(basis: list[Pair]) -> NDArray[np.float64]:
    """Shares of the basis in the vector of the lowest Rayleigh quotient."""
    projected = np.array([[vector.dot(image) for _, image in basis] for vector, _ in basis])
    shares: NDArray[np.float64] = np.linalg.eigh((projected + projected.T) / 2)[1][:, 0]
    return shares


def _sum(basis: list[Pair], shares: NDArray[np.float64]) -> Pair:
    total = tuple(vector.duplicate() for vector in basis[0])
    for number in range(2):
        total[number].set(0.0)
        total[number].maxpy(list(shares), [pair[number] for pair in basis])
    return total[0], total[1]
