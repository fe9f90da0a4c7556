"""Layers that would be afloat: contact kept, for a linear solve, at an interface that has just opened everywhere.

Where a tool is lifted, what a layer springs back in the first linear solve, or what it would move on as in the last
step, can open all of an interface at once. Then nothing may hold the layer above: the tangent is singular, and the next
correction anything. So the next linear solve keeps the nodes in contact that were so at the end of the last step, in
each interface that touches nowhere any more. All contact goes by the gap again in the one after it. A layer that does
part, such as one that hangs, is caught a few times only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.faces import Face

MOST = 3
"""Linear solves of a step that contact is kept for."""


class Catch:
    """Where contact between layers is kept.

    Args:
        face: the lower faces of the interfaces.
        interfaces: this rank's local nodes of each of them.

    Attributes:
        kept: field, 1 where contact is kept, 0 elsewhere.
        holds: whether contact is kept anywhere, on any rank.
    """

    def __init__(self, face: Face, interfaces: Sequence[NDArray[np.int64]]) -> None:
        self.face, self.interfaces, self.kept = face, interfaces, face.spaces.scalar()
        self._left, self.holds = 0, False

    def follow(self, pressure: Any) -> None:
        """Take the contact pressure, a compiled density over the face in Pa."""
        self._pressure = pressure

    def note(self) -> None:
        """Remember which nodes are in contact now, at the end of a step, and keep none."""
        self.end()
        self._closed, self._touched = self._touching()

    def begin(self) -> None:
        """Begin a step: from now on, layers may be caught."""
        self._left = MOST

    def end(self) -> None:
        """End a step: keep none, and catch nothing before the next one."""
        self._let_go()
        self._left = 0

    def watch(self) -> None:
        """Keep contact at interfaces that touch nowhere at the present displacement, and did before."""
        self._let_go()
        if not self._left or not self._touched.any():
            return
        afloat = self._touched & ~self._touching()[1]
        self.holds = bool(afloat.any())
        for number in np.flatnonzero(afloat):
            nodes = self.interfaces[number]
            self.kept.x.array[nodes] = self._closed[nodes]

    def release(self, solves: int) -> None:
        """Count a linear solve; catch nothing any more from a number of them on."""
        self._left = 0 if solves > MOST else self._left - self.holds

    def _let_go(self) -> None:
        self.kept.x.array[:], self.holds = 0.0, False

    def _touching(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Nodes in contact, of this rank's local ones, and interfaces that are so anywhere, on any rank."""
        closed = self.face.values(self._pressure) > 0
        here = [closed[nodes].any() for nodes in self.interfaces]
        return closed, np.any(self.face.spaces.mesh.comm.allgather(here), axis=0)
