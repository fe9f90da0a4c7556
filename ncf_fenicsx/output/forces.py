"""Forces of tools, mould and held sides, which balance each other and the weight."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene.stack import Sides

Floats = NDArray[np.float64]

AXES = ("x", "y")
FORCE_COLUMNS = {
    "tool_force": ("N", "upward force of the fabric on the tool, of the whole, mirror images included"),
    "tool_force_x": ("N", "its part along x; no column where a mirror image takes it up, or nothing pushes along x"),
    "tool_force_y": ("N", "the same along y"),
    "mould_force_x": ("N", "force of the fabric on the mould along x, of the whole, where it can be"),
    "mould_force_y": ("N", "the same along y"),
    "support_force": ("N", "upward force of the supports, mould included, on the fabric, of the whole"),
    "support_force_x": (
        "N",
        "force of the held sides on the fabric along x, of the whole: that on the tools and the mould together",
    ),
    "support_force_y": ("N", "the same along y"),
    "weight": ("N", "weight of the fabric, of the whole; support_force = the tools' forces + weight"),
}


class Forces:
    """Evaluates the forces of a problem.

    Args:
        problem: what is measured.
        weight: compiled virtual work of gravity; None without it.
    """

    def __init__(self, problem: Problem, weight: Any) -> None:
        self.problem, sides = problem, problem.scene.stack.sides
        self.copies = sides.copies
        free = [axis for axis in range(2) if not _mirrored(sides, AXES[axis])]
        self._pushing = [contact for contact in problem.contacts.rigid if _pushes_sideways(contact)]
        self._axes = free if self._pushing else []
        dofs, owned = problem.supports.dofs, 3 * problem.space.dofmap.index_map.size_local
        self._held = [dofs[(dofs < owned) & (dofs % 3 == axis)] for axis in range(3)]
        self._weight = self.copies * self._vertical_force(weight)

    def observe(self, residual: Floats) -> dict[str, float]:
        """Columns of the history in the trial state.

        Args:
            residual: out-of-balance forces in N of the owned dofs, reactions included.
        """
        problem, contacts = self.problem, self.problem.contacts
        row: dict[str, float] = {}
        forces = {id(contact): self.copies * contact.force() for contact in contacts.rigid}
        reactions = np.array([residual[dofs].sum() for dofs in self._held])
        held = self.copies * problem.comm.allreduce(reactions)
        for number, tool in enumerate(contacts.tools):
            row[numbered("tool_displacement", number)] = tool.lowered()
            row[numbered("tool_force", number)] = float(forces[id(tool)][2])
            row |= {numbered(f"tool_{name}", number): value for name, value in self._sideways(tool, forces)}
        if contacts.mould is not None:
            held[2] -= forces[id(contacts.mould)][2]
            row |= {f"mould_{name}": value for name, value in self._sideways(contacts.mould, forces)}
        row["support_force"] = float(held[2])
        row |= {f"support_force_{AXES[axis]}": float(held[axis]) for axis in self._axes}
        return row | {"weight": self._weight}

    def _sideways(self, contact: RigidContact, forces: dict[int, Floats]) -> list[tuple[str, float]]:
        """Names and values in N of the horizontal forces on a rigid surface that may have some."""
        axes = self._axes if contact in self._pushing else []
        return [(f"force_{AXES[axis]}", float(forces[id(contact)][axis])) for axis in axes]

    def _vertical_force(self, form: Any) -> float:
        """Sum of the nodal forces along z of a compiled residual term in N, of the modelled part; 0 for None."""
        if form is None:
            return 0.0
        return float(self.problem.comm.allreduce(self.problem.contacts.body.spaces.forces(form)[:, 2].sum()))


def _mirrored(sides: Sides, axis: str) -> bool:
    """Whether the whole has an image across an axis, whose force along that axis is the opposite."""
    return "symmetry" in (getattr(sides, f"{axis}_min"), getattr(sides, f"{axis}_max"))


def _pushes_sideways(contact: RigidContact) -> bool:
    """Whether a surface can push the fabric along a horizontal: by friction, or by pressure where it is no plane."""
    return contact.traction is not None or contact.surface.kind != "plate"
