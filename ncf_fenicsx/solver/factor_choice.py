"""Which factors the tangent of a scene gets, and whether they are kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.scene.settings import Solver as Settings
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.equations import System
from ncf_fenicsx.solver.layer_factors import LayerFactors
from ncf_fenicsx.solver.linear_solver import Factors, LinearSolver
from ncf_fenicsx.solver.multigrid import multigrid

LARGE = 20_000
"""Unknowns from which on factors are kept: below, runs take seconds either way, and new ones take fewer iterations."""


def linear_solver(system: System, settings: Settings, vector: Any, constrained: NDArray[np.int32]) -> LinearSolver:
    """The linear solver of a scene.

    Args:
        system: whose tangent is solved with.
        settings: of the scene.
        vector: shared by the ranks as the unknowns are.
        constrained: owned dofs whose displacement is given.
    """
    automatic = settings.factors == "automatic" and vector.getSize() >= LARGE
    keeps = automatic or settings.factors in ("kept", "layers", "multigrid")
    return LinearSolver(_factors(system, settings.factors, vector, constrained), keeps)


def _factors(system: System, way: str, vector: Any, constrained: NDArray[np.int32]) -> Factors:
    if way not in ("layers", "multigrid"):
        return DirectFactors(vector.comm, system.symmetric)
    first, last = vector.getOwnershipRange()
    positions = system.displacement.function_space.tabulate_dof_coordinates()[: (last - first) // 3]
    if way == "multigrid":
        return multigrid(vector.comm, positions, system.sublaminates, constrained)
    return LayerFactors(vector.comm, system.symmetric, positions, system.sublaminates, first, constrained)
