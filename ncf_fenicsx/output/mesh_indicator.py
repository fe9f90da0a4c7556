"""Where along x and y the means of Vf in elements are off, at each time of a run: what a mesh is made from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.output.error_estimate import Recovery

Floats = NDArray[np.float64]


class MeshIndicator:
    """Squares of the slopes of the smoothed field of Vf, over the whole stack.

    Args:
        problem: whose mesh is extruded from one grid for all layers.
        recovery: smooths the field in the plane.
        lines: x and y in m of the grid's lines.
        volumes: of this rank's cells in m3.

    Attributes:
        lines: as given.
        squares: of each time, integrals of (dVf/dx)^2 across x in m2/m2, in each interval of x; and of (dVf/dy)^2
            across y, in each interval of y.
        change: largest integral of (Vf - Vf0)^2 over the stack so far, in m3.
    """

    def __init__(self, problem: Problem, recovery: Recovery, lines: tuple[Floats, Floats], volumes: Floats) -> None:
        self._comm, self._recovery, self.lines, self._volumes = problem.comm, recovery, lines, volumes
        self._rest = problem.scene.stack.initial_volume_fraction
        spaces = problem.contacts.body.spaces.scalars
        middles = spaces.tabulate_dof_coordinates()[spaces.dofmap.list[: len(volumes), :8]].mean(axis=1)
        self._interval = [np.searchsorted(line, middles[:, axis]) - 1 for axis, line in enumerate(lines)]
        self.squares: list[tuple[Floats, Floats]] = []
        self.change = 0.0

    def watch(self, vf: Floats) -> None:
        """Take the means of Vf in this rank's cells in; collective."""
        off = self._recovery.off(vf).reshape(-1, 2, 2)  # y, then x
        self.squares.append((self._along(0, off), self._along(1, off)))
        self.change = max(self.change, self._comm.allreduce(float((vf - self._rest) ** 2 @ self._volumes)))

    def _along(self, axis: int, off: Floats) -> Floats:
        """Integrals of squared slopes along an axis, from values at corners of shape (cells, 2 along y, 2 along x)."""
        rises, lengths = np.diff(off, axis=2 - axis).mean(axis=(1, 2)), np.diff(self.lines[axis])
        slopes = rises / lengths[self._interval[axis]]
        sums = np.bincount(self._interval[axis], slopes**2 * self._volumes, len(lengths))
        squares: Floats = self._comm.allreduce(sums) / lengths
        return squares
