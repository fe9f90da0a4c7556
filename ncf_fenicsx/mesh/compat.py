"""The DOLFINx calls whose form differs between versions, and nothing else."""

from __future__ import annotations

import math
import re
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import basix.ufl
import dolfinx
import numpy as np
import ufl
from dolfinx import cpp, fem, la
from dolfinx.fem import petsc
from mpi4py import MPI

IS_0_9 = dolfinx.__version__.startswith("0.9.")
"""Else it is a later one, of the form that 0.11 has."""
TAG = 1200
"""Of messages between ranks, which later versions ask for; any number will do."""


def processor_lines() -> list[str]:
    """What the system says of its processors; nothing where it does not say it in a file."""
    file = Path("/proc/cpuinfo")
    return file.read_text(encoding="utf-8", errors="replace").splitlines() if file.exists() else []


def _vector_flags() -> list[str]:
    """Options of a compiler for processors with AVX2, which all of x86 have had since 2015; none for others."""
    features = next((line.split() for line in processor_lines() if line.startswith("flags")), [])
    return ["-march=x86-64-v3"] if {"avx2", "fma", "bmi2", "movbe", "f16c"}.issubset(features) else []


WAITING = 120
"""Time in s after which a form that another program compiles is taken for abandoned; it takes 20 s at most."""
FASTER = ["-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros", "-fassociative-math"]
"""Lets sums run in vectors: half the time of assembly, another round-off. What is not a number stays so."""
JIT = {"cffi_extra_compile_args": ["-O2", "-g0", *FASTER, *_vector_flags()], "timeout": WAITING}


def create_hexahedral_mesh(comm: MPI.Comm, cells: np.ndarray, points: np.ndarray, parts: np.ndarray) -> Any:
    """Mesh of the cells and points that each rank hands in; cell ``i`` of a rank goes to rank ``parts[i]``."""

    def partitioner(_comm: Any, _count: int, _types: Any, _cells: Any) -> Any:
        return cpp.graph.AdjacencyList_int32(parts.astype(np.int32).reshape(-1, 1))

    element = basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,))
    return dolfinx.mesh.create_mesh(comm, cells=cells, x=points, e=ufl.Mesh(element), partitioner=partitioner)


def rule_metadata(points: np.ndarray, weights: np.ndarray, degree: int) -> dict[str, Any]:
    """UFL metadata of a rule of one's own, in reference coordinates.

    FFCx 0.9 keeps what it computes at a single point for all other rules of the same integral, which are wrong then.
    So a single point has a second one beside it, without weight.
    """
    if len(points) == 1:
        points, weights = np.vstack([points, points / 2]), np.append(weights, 0.0)
    rule = {"quadrature_rule": "custom", "quadrature_points": points, "quadrature_weights": weights}
    return {"quadrature_degree": degree} | rule


def nodal_space(mesh: Any, element: Any, has_bare_entities: bool) -> Any:
    """Space of a continuous element whose values stand at nodes.

    DOLFINx allots nodes to all edges or faces as soon as some of them bear one; those in no cell are left out.
    """
    space = fem.functionspace(mesh, element)
    return _without_unused_nodes(space) if has_bare_entities else space


def _without_unused_nodes(space: Any) -> Any:
    dofmap, every = space.dofmap, space.dofmap.index_map
    uses = la.vector(every, dtype=np.float64)
    uses.array[dofmap.list.ravel()] = 1.0
    uses.scatter_reverse(la.InsertMode.add)
    owned = uses.array[: every.size_local] > 0
    size = int(owned.sum())
    start = every.comm.exscan(size) or 0
    numbers = la.vector(every, dtype=np.float64)  # global ones, exact as such up to 2^53
    local = np.cumsum(owned) - 1
    numbers.array[: every.size_local] = start + local
    numbers.scatter_forward()
    ghosts = np.setdiff1d(dofmap.list, np.arange(every.size_local))
    positions = ghosts - every.size_local
    index_map = _index_map(every.comm, size, numbers.array[ghosts], every.owners[positions])
    renumbered = np.concatenate([local, np.zeros(every.num_ghosts, dtype=np.int64)])
    renumbered[ghosts] = size + np.arange(len(ghosts))
    cells = cpp.graph.AdjacencyList_int32(renumbered[dofmap.list].astype(np.int32))
    compact = cpp.fem.DofMap(dofmap.dof_layout, index_map, dofmap.index_map_bs, cells, dofmap.bs)
    plain = space._cpp_object
    shape = [list(space.value_shape)] if IS_0_9 else []
    slim = type(plain)(space.mesh._cpp_object, plain.element, compact, *shape)
    return fem.FunctionSpace(space.mesh, space.ufl_element(), slim)


def _index_map(comm: MPI.Comm, size: int, ghosts: np.ndarray, owners: np.ndarray) -> Any:
    """Index map of a number of own entries, and of ghosts by their global numbers and owners."""
    more = [] if IS_0_9 else [TAG]
    return cpp.common.IndexMap(comm, size, ghosts.astype(np.int64), owners.astype(np.int32), *more)


def interpolation_points(element: Any) -> np.ndarray:
    """Reference points of an element's degrees of freedom."""
    points = element.interpolation_points
    return np.asarray(points() if callable(points) else points)


def coordinates(mesh: Any) -> Any:
    """Positions of a mesh's undeformed points, symbolically."""
    return ufl.SpatialCoordinate(mesh)


def create_vector(space: Any) -> Any:
    """PETSc vector of the values of one space, with those of other ranks beside them."""
    dofmap = space.dofmap
    return la.create_petsc_vector(dofmap.index_map, dofmap.index_map_bs) if IS_0_9 else petsc.create_vector(space)


def create_matrix(space: Any, links: np.ndarray) -> Any:
    """Matrix for integrals over the cells of one space, with entries for further pairs of nodes, stored one by one.

    Args:
        space: of nodal fields.
        links: global numbers of the nodes of rows and columns, shape (pairs, 2); they may belong to other ranks.
    """
    dofmap = space.dofmap
    comm, own = dofmap.index_map.comm, dofmap.index_map
    extended, local = _with_ghosts(own, links)
    pattern = cpp.la.SparsityPattern(comm, [extended, extended], [dofmap.index_map_bs] * 2)
    for nodes in dofmap.list:
        pattern.insert(nodes, nodes)
    for row, column in local:
        pattern.insert(row, column)
    pattern.finalize()
    return la.matrix_csr(pattern, la.BlockMode.expanded)


def _with_ghosts(own: Any, numbers: np.ndarray) -> tuple[Any, np.ndarray]:
    """Index map with ghosts for all global numbers, its own local numbers unchanged; and the local ones of those."""
    comm = own.comm
    starts = np.array([*comm.allgather(own.local_range[0]), own.size_global])
    known = own.local_to_global(np.arange(own.size_local + own.num_ghosts, dtype=np.int32))
    more = np.setdiff1d(numbers, known)
    if not comm.allreduce(len(more)):
        extended = own
    else:
        owners = np.searchsorted(starts, more, side="right") - 1
        ghosts = np.concatenate([own.ghosts, more]), np.concatenate([own.owners, owners])
        extended = _index_map(comm, own.size_local, *ghosts)
    every = np.concatenate([known, more])
    order = np.argsort(every)
    local = order[np.searchsorted(every, numbers, sorter=order)] if len(numbers) else numbers
    return extended, local.astype(np.int32)


def compile_form(form: ufl.Form) -> Any:
    """Compiled linear or bilinear form."""
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", "Applying str.. to a metadata value"
        )  # points of a rule: few, written in full
        return _cached(form.ufl_domains()[0], lambda: fem.form(form, jit_options=dict(JIT)))


def compile_expression(expression: Any, points: np.ndarray) -> Any:
    """Compiled expression at reference points of a cell."""
    return _cached(
        ufl.domain.extract_domains(expression)[0], lambda: fem.Expression(expression, points, jit_options=dict(JIT))
    )


def _cached(domain: Any, compiled: Callable[[], Any]) -> Any:
    """Compile, or read from the cache; a program that was killed while it compiled has left a mark there that blocks.

    Args:
        domain: UFL mesh, whose ranks all come here.
        compiled: compiles it.
    """
    start = time.time()
    try:
        return compiled()
    except KeyboardInterrupt:
        _forget_marks(start, math.inf)
        raise
    except (TimeoutError, RuntimeError) as error:
        if not re.search("timed out|just-in-time|JIT", str(error)):  # of this rank alone, maybe
            raise
        comm = domain.ufl_cargo().comm
        if "timed out" not in comm.bcast(str(error)):  # rank 0 knows
            raise
        if comm.rank == 0:
            _forget_marks(0.0, time.time() - 0.9 * WAITING)
        comm.barrier()
        return compiled()


def _forget_marks(earliest: float, latest: float) -> None:
    """Remove the marks of compilations from the cache that began between two times and have not ended."""
    folder = Path(dolfinx.jit.get_options()["cache_dir"])
    for mark in folder.glob("libffcx_*.c"):
        if not mark.with_suffix(".c.cached").exists() and earliest <= mark.stat().st_mtime <= latest:
            mark.unlink(missing_ok=True)
