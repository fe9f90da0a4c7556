"""Whether a symmetric matrix has a negative eigenvalue, from an approximate inverse: one found is a proof, none is not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import eigh

STEPS = 4
"""Improvements of the mode at a time; it goes on where it was left, as the matrix changes little from time to time."""
DISTINCT = 1e-12
"""Square of the part of a direction across those before it that is more than round-off."""


class LowestMode:
    """A vector with a low Rayleigh quotient, improved by locally optimal conjugate gradients (Knyazev 2001)."""

    def __init__(self) -> None:
        self._mode: Any = None

    def curvature(self, matrix: Any, precondition: Callable[[Any, Any], None]) -> float:
        """Rayleigh quotient in N/m after some improvements, or the first negative one.

        Args:
            matrix: symmetric.
            precondition: puts the approximate inverse, times its first argument, in the second.
        """
        x = self._mode = self._mode or _start(matrix)
        x.normalize()
        image, before = _image(matrix, x), None
        quotient = x.dot(image)
        for _ in range(STEPS):
            if quotient < 0:
                break
            across, downhill = image.copy(), x.duplicate()
            across.axpy(-quotient, x)
            precondition(across, downhill)
            basis = [(x, image), (downhill, _image(matrix, downhill)), *([before] if before else [])]
            before = _combined(basis)
            x.axpby(1.0, self._share, before[0])
            quotient = x.dot(image)
        return float(quotient)


def _start(matrix: Any) -> Any:
    """The same numbers at the same nodes, whatever their rank."""
    start = matrix.createVecRight()
    first, end = start.getOwnershipRange()
    start.array[:] = np.sin(1.0 + np.arange(first, end) ** 2 % 97)
    return start
