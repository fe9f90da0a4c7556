"""A tool under a given force: its height is an unknown of the step, solved with the displacement."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_fields import Location, StateField
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Tool

Floats = NDArray[np.float64]

FIRST_TOUCH = 1e-6
"""Penetration over a layer's thickness that a tool starts with where it has to feel a force."""


class _Step(NamedTuple):
    """The end of a step.

    Attributes:
        segment: number of the segment that it is in.
        force_at_start: force on the tool in N at the start of that segment, of the whole.
        force: the same at the end of the step.
        height: of the tool in m, what forces have added to that of its path.
        velocity: with which that has grown in m/s.
    """

    segment: float
    force_at_start: float
    force: float
    height: float
    velocity: float


class ForceControl:
    """The equation of a tool's height: the fabric's upward force on it is that of its path.

    Moving the tool up is moving all of the fabric down for it, so the derivatives by its height are those of its
    contact by a uniform displacement.

    Args:
        contact: of the tool.
        copies: factor from the modelled part's forces to those of the whole.

    Attributes:
        target: force in N that the modelled part has to carry at the end of the step; None where the height is given.
        state: what is remembered of the last step.
    """

    def __init__(self, contact: RigidContact, copies: int) -> None:
        assert isinstance(contact.surface, Tool)
        self.contact, self.copies, self.path = contact, copies, contact.surface.path
        u, v = contact.body.displacement, contact.body.variation
        up = ufl.as_vector([0.0, 0.0, 1.0])
        self._column = compat.compile_form(ufl.derivative(contact.term, u, -up))
        self._row = compat.compile_form(ufl.derivative(ufl.replace(contact.term, {v: up}), u, v))
        self.target: float | None = None
        self._time = self._size = 0.0
        self.state = StateField(f"{contact.name}.control", Location.EVERYWHERE, np.zeros(5), self._end_of_step)

    @property
    def active(self) -> bool:
        """Whether the step is under a given force."""
        return self.target is not None

    def begin(self, time: float, size: float) -> None:
        """Take the force at the end of a step from ``time`` by ``size`` (s), and predict the height."""
        self._time, self._size = time + size, size
        force = motion.force(self.path, self._time, self._force_at_start()) if size else None
        self.target = None if force is None else force / self.copies
        if force is not None and self._number == self._last.segment:
            self.contact.shift(size * self._last.velocity)

    def touch(self) -> None:
        """Lower a tool that has to feel a force, but does not yet, until it does."""
        gap = self.contact.lowest_gap()
        if self.active and gap > 0:
            self.contact.shift(-gap - FIRST_TOUCH * self.contact.body.thickness)

    def _end_of_step(self) -> Floats:
        """What is to be remembered of the trial state."""
        height = self.contact.height_offset
        velocity = (height - self._last.height) / self._size if self._size and self.active else 0.0
        force = self.copies * float(self.contact.force()[2])
        return np.array([self._number, self._force_at_start(), force, height, velocity])

    @property
    def _last(self) -> _Step:
        """What is remembered of the last step."""
        return _Step(*self.state.committed)

    @property
    def _number(self) -> int:
        """Number of the segment that the step is in."""
        return motion.segment_number(self.path, self._time)

    def _force_at_start(self) -> float:
        """Force in N at the start of the segment that the step is in."""
        return self._last.force_at_start if self._number == self._last.segment else self._last.force

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
