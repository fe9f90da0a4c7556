"""The DOLFINx calls whose form differs between versions, and nothing else."""

from __future__ import annotations

import warnings
from typing import Any

import basix.ufl
import dolfinx
import numpy as np
import ufl
from dolfinx import cpp, fem
from mpi4py import MPI

JIT = {"cffi_extra_compile_args": ["-O2", "-g0"], "timeout": 600}
"""Rank 0 compiles while the others wait, so the waiting limit is generous."""


def create_hexahedral_mesh(comm: MPI.Comm, cells: np.ndarray, points: np.ndarray, parts: np.ndarray) -> Any:
    """Mesh of the cells and points that each rank hands in; cell ``i`` of a rank goes to rank ``parts[i]``."""

    def partitioner(_comm: Any, _count: int, _types: Any, _cells: Any) -> Any:
        return dolfinx.graph.adjacencylist(parts.astype(np.int32).reshape(-1, 1))

    element = basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,))
    return dolfinx.mesh.create_mesh(comm, cells=cells, x=points, e=ufl.Mesh(element), partitioner=partitioner)


def interpolation_points(element: Any) -> np.ndarray:
    """Reference points of an element's degrees of freedom."""
    points = element.interpolation_points
    return np.asarray(points() if callable(points) else points)


def coordinates(mesh: Any) -> Any:
    """Places of a mesh's undeformed points, symbolically."""
    return ufl.SpatialCoordinate(mesh)


def sparsity_pattern(form: Any) -> Any:
    """Pattern of a bilinear form, open for further entries."""
    return fem.create_sparsity_pattern(form)


def create_matrix(comm: MPI.Comm, pattern: Any) -> Any:
    """PETSc matrix with a finished pattern."""
    return cpp.la.petsc.create_matrix(comm, pattern)


def compile_form(form: ufl.Form) -> Any:
    """Compiled linear or bilinear form."""
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", "Applying str.. to a metadata value"
        )  # points of a rule: few, written in full
        return fem.form(form, jit_options=dict(JIT))


def compile_expression(expression: Any, points: np.ndarray) -> Any:
    """Compiled expression at reference points of a cell."""
    return fem.Expression(expression, points, jit_options=dict(JIT))
