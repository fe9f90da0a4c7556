"""What contact remembers at the nodes of a face: committed with an accepted step, restored after one that fails."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_parts import Place, StatePart

Floats = NDArray[np.float64]


class Memory:
    """Fields at nodes, each with the expression that gives its value at the end of a step.

    Args:
        face: whose nodes they stand at.

    Attributes:
        fields: by name, as the forms use them.
    """

    def __init__(self, face: Face) -> None:
        self.face = face
        self.fields: dict[str, Any] = {}
        self._committed: dict[str, Any] = {}
        self._updates: dict[str, Any] = {}

    def scalar(self, name: str) -> Any:
        """A new scalar field, 0 at the start."""
        return self._keep(name, self.face.spaces.scalar())

    def vector(self, name: str) -> Any:
        """A new vector field, 0 at the start."""
        return self._keep(name, self.face.spaces.vector())

    def _keep(self, name: str, field: Any) -> Any:
        self.fields[name], self._committed[name] = field, field.x.array.copy()
        return field

    def follow(self, name: str, update: Any) -> None:
        """Take the compiled density over the face that gives a field's value at the end of a step."""
        self._updates[name] = update

    def update(self, name: str) -> None:
        """Give a field its value of the present state, to be committed or rolled back later."""
        self.fields[name].x.array[:] = self.face.values(self._updates[name]).ravel()

    def commit(self) -> None:
        """Give all fields their values of the present state, each of which may depend on all old ones."""
        values = {name: self.face.values(form).ravel() for name, form in self._updates.items()}
        for name, value in values.items():
            self._set(name, value)

    def parts(self) -> dict[str, StatePart]:
        """The committed values, for a checkpoint."""
        return {name: self._part(name) for name in self.fields}

    def _part(self, name: str) -> StatePart:
        return StatePart(Place.NODES, lambda: self._committed[name], lambda rows: self._set(name, rows.ravel()))

    def _set(self, name: str, values: Floats) -> None:
        self._committed[name] = values
        self.fields[name].x.array[:] = values

    def rollback(self) -> None:
        """Return to the committed values."""
        for name, value in self._committed.items():
            self.fields[name].x.array[:] = value
