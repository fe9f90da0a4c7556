"""What holds the stack: the rigid plane below it, and its lateral sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.scene import Scene

NORMAL_AXIS = {"x_min": 0, "x_max": 0, "y_min": 1, "y_max": 1, "bottom": 2}


@dataclass(frozen=True)
class Supports:
    """Homogeneous Dirichlet conditions.

    Attributes:
        conditions: DOLFINx conditions.
        dofs: all local dofs they constrain, ghosts included.
        vertical_dofs: owned dofs among them that act along z.
    """

    conditions: list[Any]
    dofs: NDArray[np.int32]
    vertical_dofs: NDArray[np.int32]


def support(space: Any, stack: StackMesh, scene: Scene) -> Supports:
    """The bottom slides on a rigid plane, if on no mould; fixed sides do not move; symmetry planes are not crossed."""
    held = []
    for name, side in scene.stack.sides:
        if side != "free" and not (name == "bottom" and scene.mould is not None):
            held += [(name, axis) for axis in range(3) if side == "fixed" or axis == NORMAL_AXIS[name]]
    conditions = [_condition(space, stack.facets(name), axis) for name, axis in held]
    none = np.zeros(0, dtype=np.int32)
    dofs = np.unique(np.concatenate([none, *(condition.dof_indices()[0] for condition in conditions)]))
    owned = 3 * space.dofmap.index_map.size_local
    return Supports(conditions, dofs, dofs[(dofs < owned) & (dofs % 3 == 2)])


def _condition(space: Any, facets: Any, axis: int) -> Any:
    dofs = fem.locate_dofs_topological(space.sub(axis), 2, facets)
    return fem.dirichletbc(np.float64(0.0), dofs, space.sub(axis))
