"""Work of the tools and of friction, and what a viscosity that only stabilises the solution has taken of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_fields import Location, StateField
from ncf_fenicsx.output.friction_work import FrictionWork
from ncf_fenicsx.output.tool_work import ToolWork

Floats = NDArray[np.float64]

COLUMNS = {
    "tool_work": ("J", "work of the tools on the fabric since the start, of the whole"),
    "tool_work_error": ("J", "estimated error of that by the size of the steps"),
    "friction_work": (
        "J",
        "what friction of tools, mould and layers has dissipated since the start, of the whole",
    ),
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
        state: sums so far, and forces, positions and pressures at the ends of the last steps.
        work: of the tools.
        friction: its work.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.copies = problem, problem.scene.stack.sides.copies
        self._viscous: tuple[Any, Any] | None = None
        numbers = np.zeros(1 + ToolWork.size(3 * len(problem.contacts.tools)))
        self.friction = FrictionWork(problem)
        self.state = [StateField("energies", Location.EVERYWHERE, numbers), *self.friction.state]
        self._taken = numbers[:1]
        self.work = ToolWork(numbers[1:], problem.scene.milestones)

    def _viscous_forms(self) -> tuple[Any, Any]:
        """The viscosity's virtual work, and that for the step's motion: its energy in J of the step."""
        problem, work = self.problem, self.problem.terms["viscosity"]
        moved = problem.displacement - problem.start
        return compat.compile_form(work), compat.compile_form(ufl.replace(work, {problem.variation: moved}))

    def _stabilised(self) -> dict[str, float]:
        """Columns on the viscosity; its forms are made when there is some for the first time."""
        problem, work, force = self.problem, self.work.total, 0.0
        if self._viscous is None and "viscosity" in problem.terms:
            self._viscous = self._viscous_forms()
        if self._viscous is not None:
            forces = problem.contacts.body.spaces.forces(self._viscous[0])[:, 2]
            parts = np.array([np.abs(forces).sum(), float(fem.assemble_scalar(self._viscous[1]))])
            force, energy = self.copies * problem.comm.allreduce(parts)
            self._taken += abs(energy)
        return {"viscous_force": float(force), "viscous_share": float(self._taken[0]) / work if work > 0 else 0.0}

    def observe(self, time: float) -> dict[str, float]:
        """Columns of the history in the trial state at a time (s); to be called once a step, before its commit."""
        tools = self.problem.contacts.tools
        forces = self.copies * np.array([tool.force() for tool in tools]).ravel()
        self.work.add(time, forces, np.array([tool.tip.value for tool in tools]).ravel())
        columns = {"tool_work": self.work.total, "tool_work_error": self.work.error} if tools else {}
        return (
            columns | self.friction.observe() | (self._stabilised() if self.problem.scene.solver.may_stabilise else {})
        )
