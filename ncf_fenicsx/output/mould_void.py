"""The opening between the stack and the mould that it lies on."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.output.face_waves import LayerFace
from ncf_fenicsx.output.voids import voids

Floats = NDArray[np.float64]

OPEN = 0.01
"""Opening over a layer's thickness from which on it is a void with a length."""
VOID_COLUMNS = {
    "gap_max": ("m", "widest opening"),
    "void_volume": ("m3", "volume of the openings, of the whole"),
    "void_longest": ("m", "longest extent along x or y of a connected opening wider than 1 % of a layer"),
}


class MouldVoid:
    """Evaluates the opening over a mould.

    Args:
        contact: with the mould.
        face: lower face of the stack.
        area_vector: current normal of the layers times their area stretch.
        problem: what is measured.
    """

    def __init__(self, contact: RigidContact, face: LayerFace, area_vector: Expression, problem: Problem) -> None:
        self.contact, self.face, self.problem = contact, face, problem
        body = problem.contacts.body
        point = ufl.variable(body.position - contact.tip)
        gap = contact.surface.with_constants(body.constants).signed_distance(point)
        # the face's area as the mould sees it: a face that leans over a plate covers less of it than its own area
        seen = ufl.dot(area_vector, ufl.diff(gap, point))
        self._volume: Any = compat.compile_form(ufl.max_value(gap, 0) * seen * contact.face.measure)

    def observe(self) -> dict[str, float]:
        """Values of `VOID_COLUMNS` in the trial state."""
        problem, whole = self.problem, self.face.whole
        gap = self.face.gather(self.contact.gaps())
        plan = self.face.current(problem.displacement.x.array.reshape(-1, 3))[:, :2]
        open_ = voids(plan, whole.quads, gap, np.zeros(len(gap)), OPEN * problem.scales.length)
        volume = problem.scene.stack.sides.copies * problem.comm.allreduce(float(fem.assemble_scalar(self._volume)))
        return dict(zip(VOID_COLUMNS, [open_.widest_opening, volume, open_.longest], strict=True))
