"""A tangent as few motions see it."""

from __future__ import annotations

from typing import Any


def galerkin(matrix: Any, motions: Any, before: Any) -> Any:
    """Galerkin's approximation of a matrix by motions of its unknowns.

    A motion that is constrained at all nodes, at a plane of symmetry say, gets the row of the unit matrix.

    Args:
        matrix: the tangent.
        motions: matrix from the sizes of the motions to the displacements of all nodes.
        before: approximation of an earlier tangent of the same pattern, whose memory is taken; None if there is none.
    """
    coarse = matrix.ptap(motions, before)
    diagonal = coarse.getDiagonal()
    diagonal.array[diagonal.array == 0.0] = 1.0
    coarse.setDiagonal(diagonal)
    return coarse
