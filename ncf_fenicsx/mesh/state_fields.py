"""Fields of state: committed with an accepted step, restored after one that fails, kept in checkpoints.

All that a run remembers is a list of them, so commit, rollback and checkpoint are loops over that list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from functools import partial
from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import CELL, Element
from ncf_fenicsx.mesh.faces import Face

Floats = NDArray[np.float64]


class Location(Enum):
    """Where the values of a field stand."""

    NODES = "this rank's local nodes"
    CELLS = "this rank's local cells"
    EVERYWHERE = "shared by all ranks"


class StateField:
    """One field of state.

    Args:
        name: in checkpoints; no two fields of a run share it.
        location: where its values stand.
        values: of the trial state, changed in place, so that forms may read them.
        update: gives the values at the end of a step, from the trial state and all fields as they were at its start;
            what ``values`` hold then unless given.
        committed: where the values at the start of a step are kept; an array of its own unless given.
        entries: of ``values`` that belong to each node or cell, shape (rows, entries); in their order unless given.
    """

    def __init__(
        self,
        name: str,
        location: Location,
        values: Floats,
        update: Callable[[], Floats] | None = None,
        committed: Floats | None = None,
        entries: NDArray[np.int32] | None = None,
    ) -> None:
        self.name, self.location, self.values = name, location, values
        self._update, self._entries = update, entries
        self.committed: Floats = values.copy() if committed is None else committed

    def trial(self) -> Floats:
        """Values at the end of the step in the trial state, those of a node or cell together."""
        return self._rows(self.values).copy() if self._update is None else self._update()

    def advance(self) -> None:
        """Take the values of the trial state, to be committed or rolled back later."""
        self._put(self.values, self.trial())

    def commit(self, rows: Floats) -> None:
        """Take values, those of a node or cell together, as committed ones."""
        self._put(self.values, rows)
        self.committed[:] = self.values

    def rollback(self) -> None:
        """Return to the committed values."""
        self.values[:] = self.committed

    def committed_rows(self) -> Floats:
        """Committed values, those of a node or cell together."""
        return self._rows(self.committed)

    def _rows(self, values: Floats) -> Floats:
        return values if self._entries is None else values[self._entries]

    def _put(self, values: Floats, rows: Floats) -> None:
        if self._entries is None:
            values[:] = rows.ravel()
        else:
            values[self._entries] = rows.reshape(self._entries.shape)


def commit(fields: Iterable[StateField]) -> None:
    """Commit all fields; the new values of each may depend on the old ones of all."""
    trials = [(field, field.trial()) for field in fields]
    for field, rows in trials:
        field.commit(rows)


def rollback(fields: Iterable[StateField]) -> None:
    """Return all fields to their committed values."""
    for field in fields:
        field.rollback()


def functions_at_points(mesh: Any, element: Any, initial: dict[str, float]) -> dict[str, Any]:
    """DOLFINx functions with values at points of the cells.

    Args:
        mesh: DOLFINx mesh.
        element: Basix element whose points they stand at, see `at_volume_points` and `at_nodes`.
        initial: names with their values at the start.
    """
    if not initial:
        return {}
    space = fem.functionspace(mesh, element)
    functions = {name: fem.Function(space, name=name) for name in initial}
    for name, value in initial.items():
        functions[name].x.array[:] = value
    return functions


def towards_middle(mesh: Any, share: float) -> Any:
    """UFL vector (m), in the plane of a layer, from a point of a cell to a share of the way to the cell's middle."""
    middle = fem.Function(fem.functionspace(mesh, ("DG", 0, (3,))))
    middle.interpolate(lambda positions: positions)
    x, y, _ = share * (middle - ufl.SpatialCoordinate(mesh))
    return ufl.as_vector([x, y, 0])


def fields_at_points(prefix: str, functions: dict[str, Any], updates: dict[str, Expression]) -> dict[str, StateField]:
    """Fields of state whose values at the end of a step are expressions, by name.

    Args:
        prefix: of their names in checkpoints.
        functions: that hold them.
        updates: expressions for their values at the end of a step.
    """
    fields = {}
    for name, function in functions.items():
        space = function.function_space
        expression = compat.compile_expression(updates[name], compat.interpolation_points(space.element))
        cells = np.arange(space.mesh.topology.index_map(3).size_local, dtype=np.int32)
        fields[name] = StateField(
            f"{prefix}.{name}",
            Location.CELLS,
            function.x.array,
            partial(_evaluated, expression, space.mesh, cells),
            entries=space.dofmap.list,
        )
    return fields


def _evaluated(expression: Any, mesh: Any, cells: NDArray[np.int32]) -> Floats:
    """Values of a compiled expression, shape (cells, points)."""
    return np.asarray(expression.eval(mesh, cells))


def field_on_face(name: str, function: Any, face: Face, form: Any) -> StateField:
    """Field of state at the nodes of a face, whose values at the end of a step are a compiled density over it."""
    return StateField(name, Location.NODES, function.x.array, lambda: face.values(form).ravel())


def at_volume_points(element: Element) -> Any:
    """Basix element with a value at each point that volumes are integrated with."""
    points, weights = element.volume_rule
    return basix.ufl.quadrature_element(CELL, points=points, weights=weights)


def at_nodes(element: Element) -> Any:
    """Basix element with a value at each node of a cell: for faces, whose forms are evaluated there."""
    return element.basix(discontinuous=True)
