"""Fields that remember: committed with an accepted step, tried before, never touched by one that fails."""

from __future__ import annotations

from typing import Any

import basix.ufl
import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import CELL, Element
from ncf_fenicsx.mesh.state_parts import Place, StatePart

Floats = NDArray[np.float64]


class States:
    """State fields at points of the cells.

    Args:
        mesh: DOLFINx mesh.
        element: Basix element whose points they stand at, see `at_volume_points` and `at_nodes`.
        initial: names with their values at the start.
    """

    def __init__(self, mesh: Any, element: Any, initial: dict[str, float]) -> None:
        self.mesh = mesh
        self.fields: dict[str, Any] = {}
        self._updates: dict[str, Any] = {}
        self._cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
        if initial:
            self._space = fem.functionspace(mesh, element)
            self._points = compat.interpolation_points(self._space.element)
        for name, value in initial.items():
            self.fields[name] = fem.Function(self._space, name=name)
            self.fields[name].x.array[:] = value

    def follow(self, updates: dict[str, Expression]) -> None:
        """Take the expressions that give the states at the end of a step."""
        self._updates = {name: compat.compile_expression(update, self._points) for name, update in updates.items()}

    def trial(self, name: str) -> Floats:
        """A state as the present displacement gives it, shape (cells, points)."""
        return np.asarray(self._updates[name].eval(self.mesh, self._cells))

    def commit(self) -> None:
        """Replace all states by their trial values, each of which may depend on all old ones."""
        trials = {name: self.trial(name) for name in self._updates}
        for name, values in trials.items():
            self.fields[name].x.array[self._space.dofmap.list] = values

    def parts(self) -> dict[str, StatePart]:
        """The committed states, for a checkpoint."""
        return {name: self._part(field.x.array) for name, field in self.fields.items()}

    def _part(self, values: Floats) -> StatePart:
        dofs = self._space.dofmap.list
        return StatePart(Place.CELLS, lambda: values[dofs], lambda rows: np.put(values, dofs, rows))


def at_volume_points(element: Element) -> Any:
    """Basix element with a value at each point that volumes are integrated with."""
    points, weights = element.volume_rule
    return basix.ufl.quadrature_element(CELL, points=points, weights=weights)


def at_nodes(element: Element) -> Any:
    """Basix element with a value at each node of a cell: for faces, whose forms are evaluated there."""
    return element.basix(discontinuous=True)
