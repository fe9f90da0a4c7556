"""How Vf varies through each cell, from what presses on its faces: a profile where the mesh itself shows none."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.laws.law import CompactionStep
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.upright import NONE, Upright
from ncf_fenicsx.scene.laws import Laws

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

HALVINGS = 40
LEAST = 0.1
"""Share of Vf at rest from which on a Vf is looked for."""
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class SlowLaw:
    """What slow loading would press with in each of some cells; where one opens, what slow unloading would.

    Attributes:
        laws: of the fabric.
        rest: Vf of the fabric at rest.
        states: means in the cells of what unloading remembers, from the start of the step.
        opens: which cells open.
    """

    laws: Laws
    rest: float
    states: dict[str, Floats]
    opens: Flags

    @classmethod
    def of(cls, laws: Laws, rest: float, states: dict[str, Floats], vf: Floats) -> SlowLaw:
        """That of cells with means of Vf: those open where unloading has less pressure."""
        law = cls(laws, rest, states, np.ones(len(vf), dtype=bool))
        return replace(law, opens=law.pressure(vf) < law._loading(vf) * (1 - ROUND_OFF))

    def within(self, cells: Flags) -> SlowLaw:
        """That of some of the cells."""
        states = {name: values[cells] for name, values in self.states.items()}
        return replace(self, states=states, opens=self.opens[cells])

    def pressure(self, vf: Floats) -> Floats:
        """Pressure in Pa at a Vf in each cell."""
        if self.laws.unloading is None:
            return self._loading(vf)
        step = CompactionStep(vf, vf, self.rest, 0.0, 0.0, 0.0, self._loading)
        return np.where(self.opens, self.laws.unloading.pressure(step, self.states), self._loading(vf))

    def volume_fraction(self, pressure: Floats, limit: float) -> Floats:
        """Vf below a limit at which each cell has a pressure (Pa), by halving."""
        low, high = np.full_like(pressure, LEAST * self.rest), np.full_like(pressure, limit * (1 - ROUND_OFF))
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            above = self.pressure(middle) > pressure
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return high

    def _loading(self, vf: Floats) -> Floats:
        pressure: Floats = self.laws.compaction.pressure(vf, self.rest)
        return pressure


class ThroughProfile:
    """A parabola of Vf through each cell: its mean is that of the cell, its ends are what the faces say.

    - Between cells of one layer: the mean of both.
    - Where something touches, or nothing does: the Vf at which the laws have the pressure of the contact. The law of
      slow compaction, or of unloading where a cell opens, is taken times a factor, the same throughout a cell, for
      which the cell's mean Vf has its mean pressure: what speed and relaxation do to the law is in that factor.
    - On the plane that holds the bottom down, nothing bends, so no shear changes the pressure: the slope is zero.

    Args:
        problem: whose state is measured.
        upright: its cells as they stand on each other.
    """

    def __init__(self, problem: Problem, upright: Upright) -> None:
        scene = problem.scene
        self._upright, self._laws = upright, scene.laws
        self._rest, self._limit = scene.stack.initial_volume_fraction, scene.packing_limit[0]
        kept = scene.laws.unloading.initial_states(self._rest) if scene.laws.unloading is not None else ()
        self._states = {name: problem.states[name] for name in kept}
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
        upright = self._upright
        states = {
            name: field.committed_rows().reshape(len(vf), -1).mean(axis=1) for name, field in self._states.items()
        }
        law = SlowLaw.of(self._laws, self._rest, states, vf)
        slow = law.pressure(vf)
        told = (stress < 0) & (slow > 0)
        factor = np.divide(-stress, slow, out=np.ones_like(vf), where=told)
        ends = []
        for nodes, neighbour in ((upright.lower, upright.below), (upright.upper, upright.above)):
            outside = (neighbour == NONE) & told
            values = np.where(neighbour == NONE, vf, (vf + vf[neighbour]) / 2)
            pressed = np.maximum(pressures[nodes[outside]].mean(axis=1), 0.0) / factor[outside]
            values[outside] = law.within(outside).volume_fraction(pressed, self._limit)
            ends.append(values)
        lower, upper = ends
        return np.where(self._mirrored, (3 * vf - upper) / 2, lower), upper
