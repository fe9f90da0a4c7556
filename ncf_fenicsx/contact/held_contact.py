"""Contact kept where it was at the end of the last step, for some linear solves of the next one.

With a tool: penetrations are a thousand times smaller than what a tool moves in a step. Judged by the gap right after
that motion, all of a contact would open at once, and the first linear solve would let the pressed stack spring back. So
that solve keeps the nodes in contact that were so at the end of the last step. So does the one after it, for what the
first one left out, of second order in the motion, is still far more than a penetration: of two nodes one would open for
nothing. All solves after go by the gap. A tool that retreats would pull the fabric along: contact is kept for one only.

Between layers: where a tool is lifted, what a layer springs back in the first linear solve, or what it would move on
as in the last step, can open all of an interface at once. Then nothing may hold the layer above: the tangent is
singular, and the next correction anything. So the next linear solve keeps the nodes in contact that were so at the end
of the last step, in each interface that touches nowhere any more. All contact goes by the gap again in the one after
it. A layer that does part, such as one that hangs, is held a few times only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_fields import Location, StateField

MOST = 3
"""Linear solves of a step that contact between layers is kept for."""


class ActiveSet:
    """Nodes of a face in contact, and where contact is kept whatever the gap.

    Args:
        face: whose nodes they are.
        kept: field that the contact pressure reads: 1 where contact is kept, 0 elsewhere.
        pressure: the contact pressure, a compiled density over the face in Pa.
    """

    def __init__(self, face: Face, kept: Any, pressure: Any) -> None:
        self.face, self.kept, self._pressure = face, kept, pressure
        self.active: NDArray[np.float64] = np.zeros_like(kept.x.array)

    def touching(self) -> NDArray[np.float64]:
        """1 at this rank's local nodes in contact now, 0 at others."""
        return np.where(self.face.values(self._pressure) > 0, 1.0, 0.0)

    def open(self) -> None:
        """Keep none: contact goes by the gap."""
        self.kept.x.array[:] = 0.0


class HeldTool(ActiveSet):
    """Contact with a tool or mould, kept for the first linear solves of a step."""

    def __init__(self, face: Face, kept: Any, pressure: Any) -> None:
        super().__init__(face, kept, pressure)
        self._solves = 0

    def state(self, name: str) -> StateField:
        """The active set at the end of the last step, as a field of state."""
        return StateField(name, Location.NODES, self.active, self.touching)

    def hold(self, solves: int) -> None:
        """Keep the active set for a number of linear solves."""
        self.kept.x.array[:] = self.active
        self._solves = solves

    @property
    def holds(self) -> bool:
        """Whether contact is kept at any of this rank's nodes."""
        return bool(self.kept.x.array.any())

    def release(self, solves: int) -> None:
        """Keep none after as many linear solves."""
        if solves >= self._solves:
            self.open()


class HeldLayers(ActiveSet):
    """Contact between layers, kept for one linear solve at an interface that has just opened everywhere.

    Args:
        face: the lower faces of the interfaces.
        kept: field that the contact pressure reads.
        pressure: the contact pressure, a compiled density over the face in Pa.
        interfaces: this rank's local nodes of each interface.

    Attributes:
        holds: whether contact is kept anywhere, on any rank.
    """

    def __init__(self, face: Face, kept: Any, pressure: Any, interfaces: Sequence[NDArray[np.int64]]) -> None:
        super().__init__(face, kept, pressure)
        self.interfaces, self.holds, self._left = interfaces, False, 0
        self._touched: NDArray[np.bool_] = np.zeros(len(interfaces), dtype=bool)

    def note(self) -> None:
        """Take the present contact as the active set, at the end of a step, and keep none."""
        self.end()
        self.active = self.touching()
        self._touched = self._anywhere(self.active)

    def begin(self) -> None:
        """Begin a step: from now on, layers may be held."""
        self._left = MOST

    def end(self) -> None:
        """End a step: keep none, and hold nothing before the next one."""
        self.open()
        self._left = 0

    def open(self) -> None:
        """Keep none: contact goes by the gap."""
        super().open()
        self.holds = False

    def watch(self) -> None:
        """Keep contact at interfaces that touch nowhere at the present displacement, and did before."""
        self.open()
        if not self._left or not self._touched.any():
            return
        afloat = self._touched & ~self._anywhere(self.touching())
        self.holds = bool(afloat.any())
        for number in np.flatnonzero(afloat):
            nodes = self.interfaces[number]
            self.kept.x.array[nodes] = self.active[nodes]

    def release(self, solves: int) -> None:
        """Count a linear solve; hold nothing any more from a number of them on."""
        self._left = 0 if solves > MOST else self._left - self.holds

    def _anywhere(self, touching: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which interfaces are in contact somewhere, on any rank."""
        here = [bool(touching[nodes].any()) for nodes in self.interfaces]
        return np.any(self.face.spaces.mesh.comm.allgather(here), axis=0)
