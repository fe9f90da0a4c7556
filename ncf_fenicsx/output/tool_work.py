"""Work of the tools, integrated along their paths from forces and positions at the ends of steps. Plain arrays only.

Forces and positions are taken as cubic in time through the last four ends of steps of a piece of the path, so the error
goes with the fourth power of the step; a trapezoid between two of them goes with the second, which leaves an elastic
cycle per cents of its peak. At the start of a piece fewer ends are known, and the order is lower.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

POINTS = 4
"""Ends of steps that a polynomial goes through."""
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(POINTS)


class ToolWork:
    """Sums work over accepted steps.

    Args:
        numbers: array that holds all that is remembered, of `size` zeros at the start; changed in place.
        piece_ends: times in s at which pieces of the path end: force and speed have kinks there.
    """

    def __init__(self, numbers: Floats, piece_ends: list[float]) -> None:
        self._sums, self._count, rows = np.split(numbers, [2, 3])
        self._rows = rows.reshape(POINTS, -1)
        self._piece_ends = np.asarray(piece_ends)

    @staticmethod
    def size(components: int) -> int:
        """Numbers that are remembered for forces of so many components, those of all tools together."""
        return 3 + POINTS * (1 + 2 * components)

    @property
    def total(self) -> float:
        """Work on the fabric so far in J."""
        return float(self._sums[0])

    @property
    def error(self) -> float:
        """Estimated error of that by the size of the steps in J: what a lower order would change, summed up."""
        return float(self._sums[1])

    def add(self, time: float, forces: Floats, positions: Floats) -> None:
        """Add the step that ends at a time (s).

        Args:
            time: in s.
            forces: on the tools in N, shape (components,).
            positions: of their tips in m, shape (components,).
        """
        count = int(self._count[0])
        self._rows[:] = np.roll(self._rows, 1, axis=0)
        self._rows[0] = np.concatenate([[time], forces, positions])
        if count:
            known = self._rows[: min(count + 1, POINTS)]
            work = work_of_last_interval(known)
            self._sums += work, abs(work - work_of_last_interval(known[:-1] if len(known) > 2 else known))
        ends = self._piece_ends
        self._count[0] = 1 if np.isclose(ends, time, rtol=1e-12, atol=0).any() else min(count + 1, POINTS)


def work_of_last_interval(rows: Floats) -> float:
    """Work in J that the tools do on the fabric from the last but one of some times to the last.

    Args:
        rows: time in s, forces on the tools in N and positions in m, the last time first, shape (times, 1 + 2 n).
    """
    time, values = rows[:, 0], rows[:, 1:]
    span = time[0] - time[1]
    scaled = (time - time[1]) / span
    coefficients = np.linalg.solve(np.vander(scaled, increasing=True), values)
    forces, positions = np.split(coefficients, 2, axis=1)
    points = (GAUSS_POINTS + 1) / 2
    powers = np.vander(points, len(time), increasing=True)
    slopes = powers[:, :-1] * np.arange(1, len(time))
    power = np.einsum("pi,pi->p", powers @ forces, slopes @ positions[1:])
    return float(-GAUSS_WEIGHTS @ power / 2)
