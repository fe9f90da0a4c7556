"""Contact kept where it was, for the first linear solves of a step.

Penetrations are a thousand times smaller than what a tool moves in a step. Judged by the gap right after that motion,
all of a contact would open at once, and the first linear solve would let the pressed stack spring back. So that solve
keeps the nodes in contact that were so at the end of the last step. So does the one after it, for what the first one
left out, of second order in the motion, is still far more than a penetration: of two nodes one would let go for
nothing. All solves after go by the gap. A tool that retreats would pull the fabric along: contact is kept for one only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_parts import Place, StatePart

Floats = NDArray[np.float64]


class Grip:
    """Where contact is kept.

    Args:
        face: whose nodes they are.

    Attributes:
        kept: field, 1 where contact is kept, 0 elsewhere.
    """

    def __init__(self, face: Face) -> None:
        self.face, self.kept = face, face.spaces.scalar()
        self._closed = np.zeros_like(self.kept.x.array)
        self._solves = 0

    def follow(self, pressure: Any) -> None:
        """Take the contact pressure, a compiled density over the face in Pa."""
        self._pressure = pressure

    def note(self) -> None:
        """Remember which nodes are in contact now."""
        self._closed = np.where(self.face.values(self._pressure) > 0, 1.0, 0.0)

    def part(self) -> StatePart:
        """Where contact was at the end of the last step, for a checkpoint."""
        return StatePart(Place.NODES, lambda: self._closed, self._recall)

    def _recall(self, rows: Floats) -> None:
        self._closed = rows.ravel()

    def hold(self, solves: int) -> None:
        """Keep those for a number of linear solves."""
        self.kept.x.array[:] = self._closed
        self._solves = solves

    @property
    def holds(self) -> bool:
        """Whether contact is kept at any of this rank's nodes."""
        return bool(self.kept.x.array.any())

    def release(self, solves: int) -> None:
        """Keep none after as many linear solves: contact goes by the gap."""
        if solves >= self._solves:
            self.kept.x.array[:] = 0.0
