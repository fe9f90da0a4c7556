"""Work of the tools, and what a viscosity that only stabilises the solution has taken of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_fields import Location, StateField

Floats = NDArray[np.float64]

COLUMNS = {
    "tool_work": ("J", "work of the tools on the fabric since the start, of the whole"),
    "viscous_force": (
        "N",
        "sum of the sizes of the vertical forces of a viscosity that stabilises the stack, of the whole",
    ),
    "viscous_share": ("1", "sum of the energies that it took or gave in each step, over the work of the tools"),
}


class Energies:
    """Sums energies over accepted steps.

    Args:
        problem: what is measured.

    Attributes:
        state: sums so far, and forces and positions of the tools at the end of the last step.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.copies = problem, problem.scene.stack.sides.copies
        self._viscous: tuple[Any, Any] | None = None
        tips = self._positions()
        numbers = np.concatenate([np.zeros(2), np.zeros(tips.size), tips.ravel()])
        self.state = StateField("energies", Location.EVERYWHERE, numbers)
        self._sums, forces, tips = np.split(numbers, [2, 2 + tips.size])
        self._forces, self._tips = forces.reshape(-1, 3), tips.reshape(-1, 3)

    def _viscous_forms(self) -> tuple[Any, Any]:
        """The viscosity's virtual work, and that for the step's motion: its energy in J of the step."""
        problem, work = self.problem, self.problem.terms["viscosity"]
        moved = problem.displacement - problem.start
        return compat.compile_form(work), compat.compile_form(ufl.replace(work, {problem.variation: moved}))

    def _stabilised(self) -> dict[str, float]:
        """Columns on the viscosity; its forms are made when there is some for the first time."""
        problem, work, force = self.problem, float(self._sums[0]), 0.0
        if self._viscous is None and "viscosity" in problem.terms:
            self._viscous = self._viscous_forms()
        if self._viscous is not None:
            forces = problem.contacts.body.spaces.forces(self._viscous[0])[:, 2]
            parts = np.array([np.abs(forces).sum(), float(fem.assemble_scalar(self._viscous[1]))])
            force, energy = self.copies * problem.comm.allreduce(parts)
            self._sums[1] += abs(energy)
        return {"viscous_force": float(force), "viscous_share": float(self._sums[1]) / work if work > 0 else 0.0}

    def _positions(self) -> Floats:
        return np.array([tool.tip.value.copy() for tool in self.problem.contacts.tools]).reshape(-1, 3)

    def observe(self) -> dict[str, float]:
        """Columns of the history in the trial state; to be called once for each accepted step, before its commit."""
        tools = self.problem.contacts.tools
        forces = self.copies * np.array([tool.force() for tool in tools]).reshape(-1, 3)
        tips = self._positions()
        self._sums[0] -= 0.5 * ((forces + self._forces) * (tips - self._tips)).sum()
        self._forces[:], self._tips[:] = forces, tips
        columns = {"tool_work": float(self._sums[0])} if tools else {}
        return columns | (self._stabilised() if self.problem.scene.solver.may_stabilise else {})
