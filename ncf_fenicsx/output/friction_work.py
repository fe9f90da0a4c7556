"""Work that friction has dissipated, at tools, mould and interfaces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.layer_contact import LayerContact
from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.laws.contact import Friction
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_fields import Location, StateField

Floats = NDArray[np.float64]


class FrictionWork:
    """Sums the work of friction over accepted steps.

    Sliding happens at mu p, which changes with the pressure p during a step: the work of a step is mu times the mean of
    the pressures at its ends times what has slid, at each node. That is exact at constant pressure, whatever the step,
    and of second order in the step otherwise.

    Args:
        problem: what is measured.

    Attributes:
        state: the sum so far in J, of the modelled part, and pressures in Pa at the end of the last step.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._sum: Floats = np.zeros(1)
        self.contacts = [_SlidingContact(*pair) for pair in _frictional(problem)]
        self.state = [contact.state for contact in self.contacts]
        if self.contacts:
            self.state.append(StateField("friction_work", Location.EVERYWHERE, self._sum))

    def observe(self) -> dict[str, float]:
        """Column of the history in the trial state, none without friction; once a step, before its commit."""
        if not self.contacts:
            return {}
        self._sum += self.problem.comm.allreduce(sum(contact.dissipated() for contact in self.contacts))
        return {"friction_work": self.problem.scene.stack.sides.copies * float(self._sum[0])}


class _SlidingContact:
    """A contact with friction."""

    def __init__(self, contact: RigidContact | LayerContact, friction: Friction) -> None:
        spaces, constants = contact.body.spaces, contact.body.constants
        self.contact, self._before = contact, spaces.scalar()
        self.state = StateField(f"{contact.name}.pressure_before", Location.NODES, self._before.x.array)
        self._pressure = contact.face.density(contact.pressure)
        mean = (self._before + ufl.max_value(contact.pressure, 0)) / 2
        size = ufl.sqrt(ufl.dot(contact.slid, contact.slid))
        work = constants(friction.coefficient) * mean * size * contact.face.measure
        self._work: Any = compat.compile_form(work)

    def dissipated(self) -> float:
        """Work of the step in J, this rank's part; the pressure at its end is kept for the next one."""
        work = float(fem.assemble_scalar(self._work))
        self._before.x.array[:] = self.contact.face.values(self._pressure)
        return work


def _frictional(problem: Problem) -> Iterator[tuple[RigidContact | LayerContact, Friction]]:
    """Contacts with friction, and what it is."""
    for rigid in problem.contacts.rigid:
        if rigid.surface.friction is not None:
            yield rigid, rigid.surface.friction
    for layers in problem.contacts.layers:
        if layers.settings.friction is not None:
            yield layers, layers.settings.friction
