"""The largest stable step of central differences, from the highest frequency of each element."""

from __future__ import annotations

from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat

Floats = NDArray[np.float64]

FIRST_ITERATIONS, NEXT_ITERATIONS = 40, 4
LAYERS_SHARE = 2.0
"""Two nodes of equal mass on a spring of stiffness k: twice k over the mass of one."""


class StableStep:
    """Bounds the highest frequency of a stack of free elements, which that of the assembled stack cannot exceed.

    Elements share no nodes here (Irons and Treharne 1971: no frequency of the whole is above the highest of an element
    alone), and each has its own vector in a power iteration on all of them at once. Contact springs come on top (Weyl:
    the highest eigenvalue of a sum is at most the sum of both highest).

    Args:
        problem: the stack.
        density: with all scaling, in kg/m3.
        masses: lumped masses of this rank's local nodes in kg.

    Attributes:
        frequencies: highest angular frequency of each of this rank's elements in 1/s, after an `update`.
    """

    def __init__(self, problem: Problem, density: float, masses: Floats) -> None:
        self.problem = problem
        alone = basix.ufl.blocked_element(problem.stack.element.basix(discontinuous=True), shape=(3,))
        space = fem.functionspace(problem.mesh, alone)
        self._displacement, self._direction = fem.Function(space), fem.Function(space)
        variation = ufl.TestFunction(space)
        own = ufl.replace(
            problem.terms["internal"], {problem.displacement: self._displacement, problem.variation: variation}
        )
        self._stiffness = compat.compile_form(ufl.derivative(own, self._displacement, self._direction))
        self._nodes = problem.space.dofmap.list[: len(problem.stack.layer)]
        self._dofs = space.dofmap.list[: len(problem.stack.layer)]
        ones = fem.Constant(problem.mesh, np.ones(3))
        weight = compat.compile_form(problem.constants(density) * ufl.inner(ones, variation) * problem.volumes.all)
        self._masses = self._by_element(fem.assemble_vector(weight).array)
        self._contact = self._contact_frequency(masses)
        start = np.random.default_rng(1).standard_normal(self._masses.shape)
        self._vectors, self._left = start, FIRST_ITERATIONS
        self.frequencies: Floats = np.zeros(len(start))

    def update(self) -> float:
        """Highest angular frequency in 1/s at the present displacement, on all ranks."""
        displaced = self.problem.displacement.x.array.reshape(-1, 3)[self._nodes]
        self._displacement.x.array.reshape(-1, 3)[self._dofs] = displaced
        for _ in range(self._left):
            self._iterate()
        self._left = NEXT_ITERATIONS
        highest = float(self.frequencies.max(initial=0.0)) ** 2 + self._contact**2
        return float(np.sqrt(max(self.problem.comm.allgather(highest))))

    def _iterate(self) -> None:
        """One power iteration on every element: x -> M^-1 K x."""
        x = self._vectors / np.sqrt(np.einsum("ij,ij->i", self._masses * self._vectors, self._vectors))[:, None]
        self._direction.x.array.reshape(-1, 3)[self._dofs] = x.reshape(*self._dofs.shape, 3)
        y = self._by_element(fem.assemble_vector(self._stiffness).array) / self._masses
        self.frequencies = np.sqrt(np.sqrt(np.einsum("ij,ij->i", self._masses * y, y)))
        self._vectors = y

    def _by_element(self, values: Any) -> Floats:
        by_element: Floats = (
            np.asarray(values).reshape(-1, 3)[self._dofs].reshape(len(self._dofs), 3 * self._dofs.shape[1])
        )
        return by_element

    def _contact_frequency(self, masses: Floats) -> float:
        """Highest angular frequency in 1/s of nodes on the springs of contact alone."""
        contacts, natural = self.problem.contacts, self.problem.scene.natural_stiffness
        squares = np.zeros(len(masses))
        for rigid in contacts.rigid:
            squares += rigid.surface.penalty.resolve(natural) * rigid.face.area / masses
        for layer in contacts.layers:
            squares += LAYERS_SHARE * layer.settings.penalty.resolve(natural) * layer.face.area / masses
        return float(np.sqrt(squares.max(initial=0.0)))
