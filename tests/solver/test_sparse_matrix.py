"""The matrix that DOLFINx sums into and PETSc solves with: PETSc's own sums, entry by entry, and room for links."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from dolfinx.mesh import CellType, GhostMode, create_box, locate_entities_boundary
from mpi4py import MPI
from petsc4py import PETSc

from ncf_fenicsx.solver.sparse_matrix import SparseMatrix

NONE = np.zeros(0, dtype=np.int64)
NO_LINKS = np.zeros((0, 2), dtype=np.int64)
SUM = PETSc.Mat.InfoType.GLOBAL_SUM


@pytest.fixture
def space():
    corners = [(0.0, 0.0, 0.0), (3.0, 2.0, 1.0)]
    mesh = create_box(MPI.COMM_WORLD, corners, (4, 3, 2), CellType.hexahedron, ghost_mode=GhostMode.none)
    return fem.functionspace(mesh, ("Lagrange", 1, (3,)))


def stiffness(space, factor):
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    x = ufl.SpatialCoordinate(space.mesh)
    stretch = ufl.inner(ufl.grad(u), ufl.grad(v)) + ufl.div(u) * ufl.div(v)
    return fem.form(factor * ((1 + x[0]) * stretch * ufl.dx + x[1] * ufl.inner(u, v) * ufl.ds))


def clamped(space):
    """Two sides that share an edge, and what is constrained of this rank's own."""
    conditions = []
    for axis in range(2):
        facets = locate_entities_boundary(space.mesh, 2, lambda x, axis=axis: np.isclose(x[axis], 0.0))
        conditions.append(fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(space, 2, facets), space))
    constrained = np.unique(np.concatenate([condition.dof_indices()[0] for condition in conditions]))
    return conditions, constrained[constrained < 3 * space.dofmap.index_map.size_local]


def difference(ours, theirs):
    rest = ours.copy()
    rest.axpy(-1.0, theirs, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    return rest.norm()


def test_entries_are_those_of_petsc_however_often_they_are_summed(space):
    conditions, constrained = clamped(space)
    ours = SparseMatrix(space, NO_LINKS, constrained)
    for factor in (1.0, -2.5):
        form = stiffness(space, factor)
        ours.assemble(form, conditions)
        ours.petsc.assemble()
        theirs = fem_petsc.assemble_matrix(form, bcs=conditions)
        theirs.assemble()
        assert theirs.norm() > 1.0
        assert difference(ours.petsc, theirs) < 1e-13 * theirs.norm()
    assert ours.petsc.getInfo(SUM)["nz_used"] == theirs.getInfo(SUM)["nz_used"]


def test_links_between_any_nodes_take_entries_from_any_rank_and_are_kept(space):
    last = space.dofmap.index_map.size_global - 1
    links = np.array([[0, last], [last, 0], [last, 1]])
    ours = SparseMatrix(space, links if MPI.COMM_WORLD.rank == 0 else NO_LINKS, NONE)
    form = stiffness(space, 1.0)
    theirs = fem_petsc.assemble_matrix(form)
    theirs.assemble()
    room = ours.petsc.getInfo(SUM)["nz_used"]
    assert room == theirs.getInfo(SUM)["nz_used"] + 9 * len(links)
    ranks = MPI.COMM_WORLD.size
    for share in (1.0, 2.0):
        ours.assemble(form, [])
        blocks = share * np.arange(9.0).reshape(1, 3, 3)
        ours.petsc.setValuesBlockedRCV(
            np.array([[0]], dtype=PETSc.IntType), np.array([[last]], dtype=PETSc.IntType), blocks, PETSc.InsertMode.ADD
        )
        ours.petsc.assemble()
        added = np.sqrt(np.sum((ranks * blocks) ** 2))
        assert difference(ours.petsc, theirs) == pytest.approx(added, rel=1e-12)
        assert ours.petsc.getInfo(SUM)["nz_used"] == room


def test_an_entry_without_a_link_is_refused(space):
    ours = SparseMatrix(space, NO_LINKS, NONE)
    last = space.dofmap.index_map.size_global - 1
    first = space.dofmap.index_map.local_range[0]
    far = last if first == 0 else 0
    with pytest.raises(PETSc.Error):
        ours.petsc.setValuesBlocked([first], [far], np.ones((3, 3)), PETSc.InsertMode.ADD)


def test_one_rank_has_its_entries_once_in_memory(space):
    ours = SparseMatrix(space, NO_LINKS, NONE)
    ours.assemble(stiffness(space, 1.0), [])
    ours.petsc.assemble()
    ours.petsc.scale(2.0)
    shared = np.allclose(ours._values[:9], 2.0 * _fresh(space)._values[:9])
    assert shared == (MPI.COMM_WORLD.size == 1)


def _fresh(space):
    matrix = SparseMatrix(space, NO_LINKS, NONE)
    matrix.assemble(stiffness(space, 1.0), [])
    return matrix
