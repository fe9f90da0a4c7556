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


def held(space):
    """Two sides that share an edge, each by one component after the other, as the stack's supports are."""
    conditions = []
    for axis in range(2):
        facets = locate_entities_boundary(space.mesh, 2, lambda x, axis=axis: np.isclose(x[axis], 0.0))
        for part in (space.sub(component) for component in range(3)):
            dofs = fem.locate_dofs_topological(part, 2, facets)
            conditions.append(fem.dirichletbc(np.float64(0.0), dofs, part))
    return conditions


def difference(ours, theirs):
    """Entries that differ, by row and column, of all ranks."""
    rest = ours.copy()
    rest.axpy(-1.0, theirs, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    starts, columns, values = rest.getValuesCSR()
    rows = rest.getOwnershipRange()[0] + np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    differ = np.abs(values) > 1e-13 * theirs.norm()
    found = dict(zip(zip(rows[differ].tolist(), columns[differ].tolist(), strict=True), values[differ], strict=True))
    return {place: value for others in MPI.COMM_WORLD.allgather(found) for place, value in others.items()}


def test_entries_are_those_of_petsc_however_often_they_are_summed(space):
    ours, conditions = SparseMatrix(space, NO_LINKS), held(space)
    for factor in (1.0, -2.5):
        form = stiffness(space, factor)
        ours.assemble(form, conditions)
        ours.petsc.assemble()
        theirs = fem_petsc.assemble_matrix(form, bcs=conditions)
        theirs.assemble()
        assert theirs.norm() > 1.0
        assert not difference(ours.petsc, theirs)
    assert ours.petsc.getInfo(SUM)["nz_used"] == theirs.getInfo(SUM)["nz_used"]


def test_links_between_any_nodes_take_entries_from_any_rank_and_are_kept(space):
    last = space.dofmap.index_map.size_global - 1
    links = np.array([[0, last], [last, 0], [last, 1]])
    ours = SparseMatrix(space, links if MPI.COMM_WORLD.rank == 0 else NO_LINKS)
    form = stiffness(space, 1.0)
    theirs = fem_petsc.assemble_matrix(form)
    theirs.assemble()
    room = ours.petsc.getInfo(SUM)["nz_used"]
    assert room == theirs.getInfo(SUM)["nz_used"] + 9 * len(links)
    block, ranks = 1.0 + np.arange(9.0).reshape(3, 3), MPI.COMM_WORLD.size
    for share in (1.0, 2.0):
        ours.assemble(form, [])
        for row, column in links:
            ours.petsc.setValuesBlocked([row], [column], share * (1 + column) * block, PETSc.InsertMode.ADD)
        ours.petsc.assemble()
        added = {
            (3 * row + i, 3 * column + j): pytest.approx(ranks * share * (1 + column) * block[i, j])
            for row, column in links
            for i, j in np.ndindex(3, 3)
        }
        assert difference(ours.petsc, theirs) == added
        assert ours.petsc.getInfo(SUM)["nz_used"] == room


def test_what_is_changed_by_hand_is_gone_with_the_next_sum(space):
    ours, form = SparseMatrix(space, NO_LINKS), stiffness(space, 1.0)
    ours.assemble(form, [])
    ours.petsc.assemble()
    before = ours.petsc.copy()
    diagonal = ours.petsc.getDiagonal()
    diagonal.scale(7.0)
    ours.petsc.setDiagonal(diagonal)
    assert len(difference(ours.petsc, before)) == diagonal.getSize()
    ours.assemble(form, [])
    ours.petsc.assemble()
    assert not difference(ours.petsc, before)


def test_an_entry_without_a_link_is_refused(space):
    ours = SparseMatrix(space, NO_LINKS)
    ours.assemble(stiffness(space, 1.0), [])
    ours.petsc.assemble()
    own = ours.petsc.getOwnershipRange()[0]
    coupled = ours.petsc.getRow(own)[0]
    far = np.setdiff1d(np.arange(space.dofmap.index_map.size_global), coupled // 3)[0]
    with pytest.raises(PETSc.Error):
        ours.petsc.setValuesBlocked([own // 3], [far], np.ones((3, 3)), PETSc.InsertMode.ADD)


def test_one_rank_has_its_entries_once_in_memory(space):
    ours = SparseMatrix(space, NO_LINKS)
    ours.assemble(stiffness(space, 1.0), [])
    ours.petsc.assemble()
    ours.petsc.scale(2.0)
    shared = np.allclose(ours._values[:9], 2.0 * _fresh(space)._values[:9])
    assert shared == (MPI.COMM_WORLD.size == 1)


def _fresh(space):
    matrix = SparseMatrix(space, NO_LINKS)
    matrix.assemble(stiffness(space, 1.0), [])
    return matrix
