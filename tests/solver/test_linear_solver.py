"""Factors that are kept: exact where they are new, close where they are old, given up where they do not fit."""

import numpy as np
import pytest
from assembled import COMM, run_with_factors
from petsc4py import PETSc

from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.linear_solver import LinearSolver

SIZE = 200


def spring_chain(stiff_from=SIZE, stiffness=1.0):
    """Stiffness of a chain on weak ground whose ground is stiffer from a node on."""
    matrix = PETSc.Mat().createAIJ((SIZE, SIZE), nnz=3, comm=COMM)
    for i in range(*matrix.getOwnershipRange()):
        ground = stiffness if i >= stiff_from else 0.01
        matrix[i, i] = 2 + ground
        for j in {max(i - 1, 0), min(i + 1, SIZE - 1)} - {i}:
            matrix[i, j] = -1.0
    matrix.assemble()
    return matrix


class Chain:
    """A linear solver behind a Krylov solver, as Newton's method has it, with a matrix that changes."""

    def __init__(self, keeps=True):
        self.linear, self.matrix = LinearSolver(DirectFactors(COMM, True), keeps), spring_chain()
        self.outer = PETSc.KSP().create(COMM)
        self.outer.setType("preonly")
        self.outer.getPC().setType("python")
        self.outer.getPC().setPythonContext(self.linear)
        self.load = self.matrix.createVecRight()
        self.load.set(1.0)
        self.linear.begin()

    def error(self, matrix, last=False, exact=False):
        """Largest residual of a correction with the entries of a matrix, under a load of 1 at each node."""
        matrix.copy(self.matrix, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self.linear.expect(last, exact)
        self.outer.setOperators(self.matrix)
        found, residual = self.load.duplicate(), self.load.duplicate()
        self.outer.solve(self.load, found)
        self.matrix.mult(found, residual)
        residual.axpy(-1.0, self.load)
        return residual.norm(PETSc.NormType.NORM_INFINITY)


def test_old_factors_do_for_a_tangent_that_has_changed_at_few_nodes():
    chain = Chain()
    assert chain.error(spring_chain()) < 1e-10
    assert 0 < chain.error(spring_chain(SIZE - 3, 100.0)) < 100 * DirectFactors.tolerance
    assert (chain.linear.factorisations, chain.linear.krylov_steps > 0) == (1, True)


def test_a_second_load_on_a_tangent_without_factors_of_its_own():
    chain = Chain()
    chain.error(spring_chain())
    chain.error(spring_chain(SIZE - 3, 100.0))
    chain.load.set(2.0)
    found, residual = chain.load.duplicate(), chain.load.duplicate()
    chain.outer.solve(chain.load, found)
    chain.matrix.mult(found, residual)
    residual.axpy(-1.0, chain.load)
    assert residual.norm(PETSc.NormType.NORM_INFINITY) < 200 * DirectFactors.tolerance
    assert chain.linear.factorisations == 1


def test_factors_that_do_not_fit_any_more_are_replaced():
    chain = Chain()
    chain.error(spring_chain())
    scattered = spring_chain()
    for i in range(*scattered.getOwnershipRange()):
        scattered[i, i] = 2 + 10.0 ** (i % 40 / 5)
    scattered.assemble()
    assert chain.error(scattered) < 1e-10
    assert chain.linear.factorisations == 2


@pytest.mark.parametrize("why", ["last", "exact", "not kept", "begins"])
def test_new_factors_where_they_are_asked_for(why):
    chain = Chain(keeps=why != "not kept")
    chain.error(spring_chain())
    if why == "begins":
        chain.linear.begin()
    near = spring_chain(SIZE - 3, 3.0)
    assert chain.error(near, last=why == "last", exact=why == "exact") < 1e-10
    assert chain.linear.factorisations == 2


def test_a_solve_begins_and_ends_with_factors_of_its_own_and_no_others():
    chain = Chain()
    for solve in (1, 2):
        chain.linear.begin()
        for stiffness, last in ((1.0, False), (2.0, False), (3.0, True), (4.0, True)):
            chain.error(spring_chain(SIZE - 3, stiffness), last=last)
        assert chain.linear.factorisations == 2 * solve


def test_a_singular_tangent_is_told():
    chain = Chain()
    chain.matrix.zeroEntries()
    zero = chain.matrix.copy()
    chain.error(zero)
    assert chain.outer.getConvergedReason() < 0
    chain.linear.forget()
    assert chain.error(spring_chain()) < 1e-10


@pytest.mark.two_ranks
def test_a_run_with_kept_factors_ends_in_the_same_state(table, folder):
    kept, new = (run_with_factors(table, factors, folder) for factors in ("kept", "new"))
    for name in ("tool_force", "vf_max", "vf_mean", "void_volume_1"):
        assert kept[0][name] == pytest.approx(new[0][name], rel=1e-4), name
    assert kept[1]["factorisations"] < 0.7 * new[1]["factorisations"]
    assert new[1]["krylov_steps"] == 0
    assert kept[0]["negative_pivots"] == new[0]["negative_pivots"]
    assert np.isclose(new[1]["factorisations"], new[1]["newton_iterations"], atol=2)
