"""A tool under a given force: its height is an unknown of the step, solved with the displacement."""

from __future__ import annotations

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_parts import Place, StatePart
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Tool

Floats = NDArray[np.float64]

FIRST_TOUCH = 1e-6
"""Penetration over a layer's thickness that a tool starts with where it has to feel a force."""


class ForceControl:
    """The equation of a tool's height: the fabric's upward force on it is that of its path.

    Moving the tool up is moving all of the fabric down for it, so the derivatives by its height are those of its
    contact by a uniform displacement.

    Args:
        contact: of the tool.
        copies: factor from the modelled part's forces to those of the whole.
    """

    def __init__(self, contact: RigidContact, copies: int) -> None:
        assert isinstance(contact.surface, Tool)
        self.contact, self.copies, self.path = contact, copies, contact.surface.path
        u, v = contact.body.displacement, contact.body.variation
        up = ufl.as_vector([0.0, 0.0, 1.0])
        self._column = compat.compile_form(ufl.derivative(contact.term, u, -up))
        self._row = compat.compile_form(ufl.derivative(ufl.replace(contact.term, {v: up}), u, v))
        self._segment, self._start, self._committed_force = 0, 0.0, 0.0
        self._heave, self._velocity = 0.0, 0.0
        self.target: float | None = None

    @property
    def active(self) -> bool:
        """Whether the step is under a given force."""
        return self.target is not None

    def begin(self, time: float, size: float) -> None:
        """Take the force at the end of a step from ``time`` by ``size`` (s), and predict the height."""
        start = self._start_of(time + size)
        force = motion.force(self.path, time + size, start) if size else None
        self.target = None if force is None else force / self.copies
        if force is not None and self._now == self._segment:
            self.contact.shift(size * self._velocity)

    def touch(self) -> None:
        """Lower a tool that has to feel a force, but does not yet, until it does."""
        gap = self.contact.lowest_gap()
        if self.active and gap > 0:
            self.contact.shift(-gap - FIRST_TOUCH * self.contact.body.thickness)

    def commit(self, time: float, size: float) -> None:
        """Accept the height at the end of a step of ``size`` (s)."""
        self._start, self._segment = self._start_of(time), motion.segment_number(self.path, time)
        self._velocity = (self.contact.heave - self._heave) / size if size and self.active else 0.0
        self._heave = self.contact.heave
        self._committed_force = self.copies * float(self.contact.force()[2])

    def part(self) -> StatePart:
        """The committed state, for a checkpoint."""
        return StatePart(Place.EVERYWHERE, self._numbers, self._recall)

    def _numbers(self) -> Floats:
        return np.array([self._segment, self._start, self._committed_force, self._heave, self._velocity])

    def _recall(self, rows: Floats) -> None:
        self._segment = int(rows[0])
        self._start, self._committed_force, self._heave, self._velocity = (float(value) for value in rows[1:])

    def _start_of(self, time: float) -> float:
        """Force in N at the start of the segment that ends at or after a time (s)."""
        self._now = motion.segment_number(self.path, time)
        return self._start if self._now == self._segment else self._committed_force

    def shift(self, height: float) -> None:
        """Raise the tool by a height (m) within the step."""
        self.contact.shift(height)

    def excess(self) -> float:
        """Upward force on the tool above that of its path in N, of the modelled part."""
        assert self.target is not None
        return float(self.contact.force()[2]) - self.target

    def column(self) -> Floats:
        """Derivative of the residual by the tool's height in N/m, of the owned dofs."""
        return self.contact.body.spaces.forces(self._column).ravel()

    def row(self) -> Floats:
        """Derivative of the tool's force by the displacement in N/m, of the owned dofs."""
        return self.contact.body.spaces.forces(self._row).ravel()

    def stiffness(self) -> float:
        """Derivative of the tool's force by its height in N/m."""
        return float(self.contact.body.spaces.mesh.comm.allreduce(self.column()[2::3].sum()))
