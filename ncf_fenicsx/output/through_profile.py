"""How Vf varies through each cell, from what presses on its faces: a profile where the mesh itself shows none."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.laws.law import CompactionStep
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.state_fields import Location, StateField
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
    """What slow loading, or unloading after it, would press with at some places.

    Attributes:
        laws: of the fabric.
        rest: Vf of the fabric at rest.
        states: what unloading remembers at each place, by name; empty without unloading.
    """

    laws: Laws
    rest: float
    states: dict[str, Floats]

    def within(self, places: Flags) -> SlowLaw:
        """That of some of the places."""
        return replace(self, states={name: values[places] for name, values in self.states.items()})

    def pressure(self, vf: Floats) -> Floats:
        """Pressure in Pa at a Vf at each place."""
        unloading = self.laws.unloading
        pressure: Floats = self._loading(vf) if unloading is None else unloading.pressure(self._step(vf), self.states)
        return pressure

    def updated(self, vf: Floats) -> dict[str, Floats]:
        """What unloading remembers once a Vf was reached at each place."""
        unloading = self.laws.unloading
        return {} if unloading is None else unloading.updated_states(self._step(vf), self.states)

    def volume_fraction(self, pressure: Floats, limit: float) -> Floats:
        """Vf below a limit at which each place has a pressure (Pa), by halving."""
        low, high = np.full_like(pressure, LEAST * self.rest), np.full_like(pressure, limit * (1 - ROUND_OFF))
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            above = self.pressure(middle) > pressure
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return high

    def _loading(self, vf: Floats) -> Floats:
        pressure: Floats = self.laws.compaction.pressure(vf, self.rest)
        return pressure

    def _step(self, vf: Floats) -> CompactionStep:
        return CompactionStep(vf, vf, self.rest, 0.0, 0.0, 0.0, self._loading)


class ThroughProfile:
    """A parabola of Vf through each cell: its mean is that of the cell, its ends are what the faces say.

    - Between cells of one layer: the mean of both.
    - Where something touches, or nothing does: the Vf at which the laws have the pressure of the contact. The law of
      slow compaction is taken times a factor, the same throughout a cell, for which the cell's mean Vf has its mean
      pressure: what speed and relaxation do to the law is in that factor. What unloading remembers is that of the face.
    - On the plane that holds the bottom down, nothing bends, so no shear changes the pressure: the slope is zero.

    Args:
        problem: whose state is measured.
        upright: its cells as they stand on each other.

    Attributes:
        state: what unloading remembers at the faces of the cells.
    """

    def __init__(self, problem: Problem, upright: Upright) -> None:
        scene = problem.scene
        self._upright, self._laws = upright, scene.laws
        self._rest, self._limit = scene.stack.initial_volume_fraction, scene.packing_limit[0]
        unloading, cells = scene.laws.unloading, len(problem.stack.layer)
        initial = {} if unloading is None else unloading.initial_states(self._rest)
        self._in_cells = {name: problem.states[name] for name in initial}
        self._at_faces = {name: np.full((2, cells), value) for name, value in initial.items()}
        both = np.arange(2 * cells, dtype=np.int32).reshape(2, cells).T
        self.state = [
            StateField(f"profile.{name}", Location.CELLS, values.reshape(-1), entries=both)
            for name, values in self._at_faces.items()
        ]
        on_plane = scene.mould is None and scene.stack.sides.bottom == "plane"
        self._mirrored = (upright.below == NONE) & (problem.stack.layer == 0) & on_plane

    def squares(self, vf: Floats, stress: Floats, pressures: Floats) -> Floats:
        """Mean square in each cell of the parabola less its mean, shape (cells,); once a step, before its commit.

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
        rows = {name: field.committed_rows() for name, field in self._in_cells.items()}
        cells = {name: values.mean(axis=tuple(range(1, values.ndim))) for name, values in rows.items()}
        slow = SlowLaw(self._laws, self._rest, cells).pressure(vf)
        told = (stress < 0) & (slow > 0)
        factor = np.divide(-stress, slow, out=np.ones_like(vf), where=told)
        ends = []
        for face, (nodes, neighbour) in enumerate(((upright.lower, upright.below), (upright.upper, upright.above))):
            law = SlowLaw(self._laws, self._rest, {name: values[face] for name, values in self._at_faces.items()})
            outside = (neighbour == NONE) & (told | bool(self._at_faces))
            values = np.where(neighbour == NONE, vf, (vf + vf[neighbour]) / 2)
            pressed = np.maximum(pressures[nodes[outside]].mean(axis=1), 0.0) / factor[outside]
            values[outside] = law.within(outside).volume_fraction(pressed, self._limit)
            for name, updated in law.updated(values).items():
                self._at_faces[name][face] = updated
            ends.append(values)
        lower, upper = ends
        return np.where(self._mirrored, (3 * vf - upper) / 2, lower), upper
