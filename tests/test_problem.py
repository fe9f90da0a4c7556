"""The assembled equation: tangent, objectivity, what is built, trial and committed state."""

import numpy as np
import pytest
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.problem import Problem
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.timing import Phases

COMM = MPI.COMM_WORLD
SUM = PETSc.Mat.InfoType.GLOBAL_SUM


def build(table):
    scene = Scene.from_table(table)
    problem = Problem(scene, build_mesh(scene, COMM))
    return problem, Newton(problem, scene.solver, Phases())


def assign(problem, field):
    """Set the displacement (m) from a function of coordinates (3, points)."""
    problem.displacement.interpolate(field)


def bumpy(x):
    """A large, smooth displacement that closes some pairs, opens others and presses into the tool."""
    layer = np.where(x[2] > 2.05e-3, 1.0, 0.0)
    w = -2e-4 * np.cos(300 * x[0]) * (0.3 + x[2] / 4e-3) + 3e-5 * layer * np.sin(900 * x[0])
    return np.stack([2e-7 * np.sin(500 * x[2] + 200 * x[1]), 1e-7 * np.cos(400 * x[0]), w])


def assemble_tangent(problem, newton):
    """Tangent at the present displacement."""
    newton.unknown.array[:] = problem.displacement.x.array[: newton.unknown.getLocalSize()]
    newton._tangent(None, newton.unknown, newton.matrix, newton.matrix)
    return newton.matrix


def gradient_error(problem, newton, step):
    """Relative difference of the tangent times a direction from the residual's central difference."""
    u = problem.displacement.x.array
    centre = u.copy()
    direction = fem.Function(problem.space)
    direction.interpolate(
        lambda x: np.stack([1e-3 * np.sin(300 * x[1]), 1e-3 * np.cos(200 * x[2]), np.sin(250 * x[0])])
    )
    d = direction.x.array
    d[problem.supports.dofs] = 0
    sides = []
    for sign in (1, -1):
        u[:] = centre + sign * step * d
        sides.append(newton.evaluate_residual())
    u[:] = centre
    difference = (sides[0] - sides[1]) / (2 * step)
    matrix = assemble_tangent(problem, newton)
    x, y = newton.unknown.duplicate(), newton.unknown.duplicate()
    x.array[:] = d[: x.getLocalSize()]
    matrix.mult(x, y)
    free = np.setdiff1d(np.arange(y.getLocalSize()), problem.supports.dofs)
    error = COMM.allreduce(float(((y.array_r - difference)[free] ** 2).sum()))
    size = COMM.allreduce(float((difference[free] ** 2).sum()))
    return np.sqrt(error / size)


@pytest.mark.parametrize("interface", ["one_sided", "bonded"])
def test_plain_tangent_is_the_derivative_of_the_residual(table, interface):
    table["solver"] = {"tangent": "plain"}
    table["interface"] = {"kind": interface}
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}  # so that round-off of the fibres hides nothing else
    table["tool"]["width"] = "7 mm"
    problem, newton = build(table)
    problem.begin(0.0, 12.0)
    problem.tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    assign(problem, bumpy)
    if interface == "one_sided":
        gaps = COMM.allgather(problem.coupling.gap())
        assert np.concatenate(gaps).min() < 0 < np.concatenate(gaps).max()
    assert gradient_error(problem, newton, 1e-9) < 1e-6


def test_extrapolated_tangent_is_the_plain_one_where_the_iterates_agree_and_only_there(table):
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}
    problem, newton = build(table)
    problem.begin(0.0, 12.0)
    assign(problem, bumpy)
    problem.last_iterate.x.array[:] = problem.displacement.x.array
    assert gradient_error(problem, newton, 1e-9) < 1e-6
    problem.last_iterate.x.array[:] = 0
    assert gradient_error(problem, newton, 1e-9) > 1e-4


def test_the_tangent_is_symmetric(table):
    problem, newton = build(table)
    problem.begin(0.0, 12.0)
    assign(problem, bumpy)
    matrix = assemble_tangent(problem, newton)
    difference = matrix.copy()
    difference.axpy(-1.0, matrix.copy().transpose())
    assert difference.norm() < 1e-12 * matrix.norm()


@pytest.mark.parametrize(
    "change",
    [
        {"laws": {"in_plane": {"modulus": "2 MPa"}}},
        {"laws": {"in_plane": {"modulus": "1 MPa", "poisson": 0.4}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "compaction": {"beta2": 1.6}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "rate": {"alpha1": 0.5}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "shear": {"modulus": "1 MPa"}}},
        {"interface": {"penalty": 20.0}},
        {"interface": {"stitching": "1e8 Pa/m"}},
        {"tool": {"width": "infinite", "penalty": 20.0}},
        {"tool": {"width": "infinite", "radius": "200 mm"}},
    ],
)
def test_every_parameter_changes_the_tangent(table, change):
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}
    norms = []
    for made in (table, table | change):
        problem, newton = build(made)
        problem.begin(0.0, 12.0)
        problem.tip.value[2] = 3.6e-3
        assign(problem, bumpy)
        norms.append(assemble_tangent(problem, newton).norm())
    assert abs(norms[1] / norms[0] - 1) > 1e-7


def test_forces_turn_with_the_body(table):
    """Objectivity: a rigid rotation by 90 degrees after a deformation turns the internal forces by as much."""
    del table["tool"]
    table |= {"duration": "1 s", "gravity": "0 m/s^2", "interface": {"kind": "bonded"}}
    problem, _ = build(table)
    form = fem.form(problem.terms["internal"])
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    assign(problem, bumpy)
    straight = fem.assemble_vector(form).array.reshape(-1, 3).copy()
    x = problem.space.tabulate_dof_coordinates()
    u = problem.displacement.x.array.reshape(-1, 3)
    u[:] = (x + u) @ turn.T - x
    turned = fem.assemble_vector(form).array.reshape(-1, 3)
    assert np.abs(straight).max() > 1e-3
    assert turned == pytest.approx(straight @ turn.T, abs=1e-10 * np.abs(straight).max() + 1e-8)


def test_a_scene_builds_only_what_it_names(table):
    problem, newton = build(table)
    assert set(problem.terms) == {"internal", "gravity", "tool"}
    assert set(problem.states.fields) == {"volume_fraction"}
    pairs = COMM.allreduce(len(problem.coupling.nodes))
    assert pairs == 7 * 3
    entries = newton.matrix.getInfo(SUM)["nz_allocated"]

    bare = {key: table[key] for key in ("stack",)} | {"duration": "1 s", "gravity": "0 m/s^2"}
    alone, _ = build(bare | {"interface": {"kind": "bonded"}})
    assert set(alone.terms) == {"internal"}
    assert alone.coupling is None
    assert alone.space.dofmap.index_map.size_global < problem.space.dofmap.index_map.size_global

    separate, newton_separate = build(bare | {"solver": {"tangent": "plain"}})
    assert separate.last_iterate is None
    assert (
        newton_separate.matrix.getInfo(SUM)["nz_allocated"] == entries
    )  # contact with a tool adds nothing to the pattern
    pattern = fem_petsc.create_matrix(separate.tangent_form).getInfo(SUM)["nz_allocated"]
    assert entries - pattern == 2 * 9 * pairs


def test_a_forced_failure_restores_the_state_bit_for_bit(table):
    problem, newton = build(table)
    problem.begin(0.0, 0.0)
    assert newton.solve().converged
    problem.commit(0.0)
    problem.begin(0.0, 1.0)
    assert newton.solve().converged
    problem.commit(1.0)
    before = [problem.displacement.x.array.copy(), problem.states.fields["volume_fraction"].x.array.copy()]
    before += [problem.tip.value.copy(), float(problem.clock.process_speed.value), problem.coupling.gap()]
    residual = newton.evaluate_residual()

    newton.settings = newton.settings.model_copy(update={"max_iterations": 1})
    problem.begin(1.0, 5.0)
    outcome = newton.solve()
    assert not outcome.converged
    assert "did not converge" in outcome.reason
    assert not np.array_equal(problem.displacement.x.array, before[0])
    problem.rollback(1.0)

    after = [problem.displacement.x.array, problem.states.fields["volume_fraction"].x.array]
    after += [problem.tip.value, problem.clock.process_speed.value, problem.coupling.gap()]
    for old, new in zip(before, after, strict=True):
        assert np.array_equal(old, new)
    assert np.array_equal(residual, newton.evaluate_residual())


def test_an_inverted_element_is_named(table):
    problem, _ = build(table)
    assert problem.defect() is None
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], -1.5 * x[2]]))
    assert "outside (0, 1)" in problem.defect()


def test_closed_and_open_pairs_push_and_pull(table):
    """Layers pressed together by 1 um carry the penalty; pulled apart by 1 um only the stitching."""
    table["interface"] = {"penalty": "1e9 Pa/m", "stitching": "1e5 Pa/m"}
    problem, _ = build(table)
    area = 12e-3 * 6e-3
    for lift, stiffness in ((-1e-6, 1e9), (1e-6, 1e5)):
        problem.displacement.x.array[:] = 0
        upper = problem.coupling.nodes[:, 1]
        problem.displacement.x.array.reshape(-1, 3)[upper, 2] = lift
        force = COMM.allreduce(float(problem.coupling.residual()[:, 1, 2].sum()))
        assert force == pytest.approx(stiffness * lift * area, rel=1e-12)
