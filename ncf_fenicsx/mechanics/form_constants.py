"""Constants that stand for numbers in the compiled forms: a new value needs no new compilation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray


class FormConstants:
    """Makes constants and fields of a mesh.

    Args:
        mesh: DOLFINx mesh.
        layer: layer of each local cell, 0 at the bottom.
    """

    def __init__(self, mesh: Any, layer: NDArray[np.int64]) -> None:
        self.mesh, self.layer = mesh, layer

    def __call__(self, value: float) -> Any:
        """Constant."""
        return fem.Constant(self.mesh, np.float64(value))

    def by_layer(self, values: Sequence[float]) -> Any:
        """Field with one value in each layer, from the bottom up."""
        field = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        field.x.array[field.function_space.dofmap.list[: len(self.layer), 0]] = np.asarray(values)[self.layer]
        return field
