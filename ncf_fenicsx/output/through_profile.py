"""How Vf varies through each cell, from what presses on its faces: a profile where the mesh itself shows none."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.upright import NONE, Upright

Floats = NDArray[np.float64]

HALVINGS = 40
LEAST = 0.1
"""Share of Vf at rest from which on a Vf is looked for."""


class ThroughProfile:
    """A parabola of Vf through each cell: its mean is that of the cell, its ends are what the faces say.

    - Between cells of one layer: the mean of both.
    - Where something touches, or nothing does: the Vf at which the laws have the pressure of the contact. The law of
      slow compaction is taken times a factor, the same throughout a cell, for which the cell's mean Vf has its mean
      pressure: what speed and history do to the law is in that factor.
    - On the plane that holds the bottom down, nothing bends, so no shear changes the pressure: the slope is zero.

    Args:
        problem: whose state is measured.
        upright: its cells as they stand on each other.
    """

    def __init__(self, problem: Problem, upright: Upright) -> None:
        scene = problem.scene
        self._upright, self._law = upright, scene.laws.compaction
        self._rest, self._limit = scene.stack.initial_volume_fraction, scene.packing_limit[0]
        on_plane = scene.mould is None and scene.stack.sides.bottom == "plane"
        self._mirrored = (upright.below == NONE) & (problem.stack.layer == 0) & on_plane

    def squares(self, vf: Floats, stress: Floats, pressures: Floats) -> Floats:
        """Mean square in each cell of the parabola less its mean, shape (cells,).

        Args:
            vf: means of the cells.
            stress: means of the stress across the layer in Pa, negative in compaction.
            pressures: of contacts at local nodes in Pa, 0 where nothing touches.
        """
        lower, upper = self._ends(vf, stress, pressures)
        slope, bend = (upper - lower) / 2, (upper + lower) / 2 - vf
        squares: Floats = slope**2 / 3 + bend**2 / 5  # of Legendre's first and second polynomials
        return squares

    def _ends(self, vf: Floats, stress: Floats, pressures: Floats) -> tuple[Floats, Floats]:
        """Vf at the lower and the upper face of each cell."""
        upright, slow = self._upright, self._law.pressure(vf, self._rest)
        told = (stress < 0) & (slow > 0)
        factor = np.divide(-stress, slow, out=np.ones_like(vf), where=told)
        ends = []
        for nodes, neighbour in ((upright.lower, upright.below), (upright.upper, upright.above)):
            outside = (neighbour == NONE) & told
            values = np.where(neighbour == NONE, vf, (vf + vf[neighbour]) / 2)
            pressed = pressures[nodes[outside]].mean(axis=1)
            values[outside] = self._volume_fraction(np.maximum(pressed, 0.0) / factor[outside])
            ends.append(values)
        lower, upper = ends
        return np.where(self._mirrored, (3 * vf - upper) / 2, lower), upper

    def _volume_fraction(self, pressure: Floats) -> Floats:
        """Vf at which slow compaction has a pressure (Pa), by halving."""
        low, high = np.full_like(pressure, LEAST * self._rest), np.full_like(pressure, self._limit * (1 - 1e-9))
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            above = self._law.pressure(middle, self._rest) > pressure
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return high
