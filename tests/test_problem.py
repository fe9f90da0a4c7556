"""The assembled equation: tangent, objectivity, what is built, trial and committed state."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, la
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
    matrix = newton.assemble_tangent()
    x, y = newton.unknown.duplicate(), newton.unknown.duplicate()
    x.array[:] = d[: x.getLocalSize()]
    matrix.mult(x, y)
    free = np.setdiff1d(np.arange(y.getLocalSize()), problem.supports.dofs)
    error = COMM.allreduce(float(((y.array_r - difference)[free] ** 2).sum()))
    size = COMM.allreduce(float((difference[free] ** 2).sum()))
    return np.sqrt(error / size)


SOFT = {"in_plane": {"modulus": "1 MPa"}}  # so that round-off of the fibres hides nothing else
FAMILIES = {"kind": "fibre_families", "modulus": "2 MPa", "modulus_compression": "1 MPa", "transition": 1e-3}
LAWS = {
    "default": SOFT,
    "clip": SOFT | {"compaction": {"toe": "clip"}},
    "raw": SOFT | {"compaction": {"toe": "raw"}},
    "power": SOFT | {"compaction": {"kind": "power"}},
    "offset power": SOFT | {"compaction": {"kind": "offset_power"}},
    "gutowski": SOFT | {"compaction": {"kind": "gutowski"}},
    "table": SOFT | {"compaction": {"kind": "table"}},
    "local rate": SOFT | {"rate": {"feed": "local"}},
    "printed rate": SOFT | {"rate": {"feed": "local", "exponent": "as_printed", "normalised": "lowest_speed"}},
    "relaxation": SOFT | {"relaxation": {"branches": [{"share": 0.5, "time": "1 s"}, {"time": "9 s"}]}},
    "unloading": SOFT | {"unloading": {}},
    "families": {"in_plane": FAMILIES},
    "plies of each layer": {"in_plane": FAMILIES | {"plies": [[0, 45], [90, 90, -30]]}},
    "bending": SOFT | {"bending": {"modulus": "0.1 MPa"}},
    "growing shear": SOFT | {"shear": {"kind": "growing", "modulus": "1 MPa"}},
    "as printed": {"in_plane": {"kind": "as_printed", "modulus": "1 MPa"}},
    "by volume": SOFT | {"volume_fraction": "volume"},
    "logarithmic solid": {"solid": {"kind": "logarithmic"}},
    "split solid": {"solid": {"kind": "split"}},
}
"""Every law of the program, one or more times."""


def strained(table, laws, tangent="plain"):
    """A problem half-way through a step, deformed, with states that differ from the undeformed ones."""
    table |= {"laws": laws, "solver": {"tangent": tangent}, "interface": {"kind": "bonded"}}
    problem, newton = build(table)
    problem.begin(0.0, 12.0)
    problem.clock.time_step.value, problem.clock.inverse_time_step.value = 0.5, 2.0
    problem.tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    assign(problem, bumpy)
    for name, field in problem.states.fields.items():
        if name.endswith("volume_fraction"):
            field.x.array[::2] *= 1.03  # half of the points have been denser before
        else:
            field.x.array[:] = 200.0
    return problem, newton


@pytest.mark.parametrize("name", LAWS)
def test_the_tangent_of_every_law_is_the_derivative_of_its_residual(table, name):
    problem, newton = strained(table, LAWS[name])
    assert gradient_error(problem, newton, 1e-9) < 1e-6


@pytest.mark.parametrize("name", LAWS)
def test_the_program_knows_which_tangents_are_symmetric(table, name):
    problem, newton = strained(table, LAWS[name])
    asymmetry = asymmetry_of(newton.assemble_tangent())
    assert problem.symmetric == (name not in ("as printed", "by volume"))
    assert newton.snes.getKSP().getPC().getType() == ("cholesky" if problem.symmetric else "lu")
    assert asymmetry < 1e-12 if problem.symmetric else asymmetry > 1e-7


def test_the_tangent_with_extrapolated_stress_is_symmetric_too(table):
    _, newton = strained(table, {}, "extrapolated")
    assert asymmetry_of(newton.assemble_tangent()) < 1e-12


def asymmetry_of(matrix):
    difference = matrix.copy()
    difference.axpy(-1.0, matrix.copy().transpose())
    return difference.norm() / matrix.norm()


@pytest.mark.parametrize("name", LAWS)
def test_forces_of_every_law_turn_with_the_body(table, name):
    """Objectivity: a rigid rotation by 90 degrees after a deformation turns the internal forces by as much."""
    problem, _ = strained(table, LAWS[name])
    form = fem.form(problem.terms["internal"])
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    straight = forces(form)
    x = problem.space.tabulate_dof_coordinates()
    u = problem.displacement.x.array.reshape(-1, 3)
    u[:] = (x + u) @ turn.T - x
    assert np.abs(straight).max() > 1e-6
    assert forces(form) == pytest.approx(straight @ turn.T, abs=1e-10 * np.abs(straight).max())


def forces(form):
    """Nodal forces in N of a residual term."""
    vector = fem.assemble_vector(form)
    vector.scatter_reverse(la.InsertMode.add)
    vector.scatter_forward()
    return vector.array.reshape(-1, 3).copy()


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
        norms.append(newton.assemble_tangent().norm())
    assert abs(norms[1] / norms[0] - 1) > 1e-7


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


def coefficients(problem):
    """Fields that the residual is compiled with, beside the displacement."""
    return len(sum(problem.terms.values()).coefficients()) - 1


def rules(problem):
    """Quadrature rules of the internal work."""
    return len({str(integral.metadata()) for integral in problem.terms["internal"].integrals()})


NO_RATE = {"rate": {"kind": "none"}}


@pytest.mark.parametrize(
    ("laws", "states", "fields", "integrals"),
    [
        ({}, {"volume_fraction"}, 1, 1),
        ({"rate": {"feed": "process"}}, {"volume_fraction"}, 0, 1),
        (NO_RATE, {"volume_fraction"}, 0, 1),
        (NO_RATE | {"unloading": {}}, {"volume_fraction", "largest_volume_fraction"}, 1, 1),
        (NO_RATE | {"relaxation": {}}, {"volume_fraction", "relaxing_pressure_1"}, 2, 1),
        (NO_RATE | {"in_plane": {"kind": "fibre_families"}}, {"volume_fraction"}, 0, 1),
        (NO_RATE | {"in_plane": {"kind": "fibre_families", "plies": [[0], [90]]}}, {"volume_fraction"}, 2, 1),
        (NO_RATE | {"bending": {}}, {"volume_fraction"}, 0, 2),
        ({"solid": {}}, set(), 0, 1),
    ],
)
def test_a_law_that_is_not_named_has_no_state_no_field_and_no_integral(table, laws, states, fields, integrals):
    problem, _ = build(table | {"laws": laws})
    assert set(problem.states.fields) == states
    assert coefficients(problem) == fields
    assert rules(problem) == integrals
    assert (problem.last_iterate is None) == ("solid" in laws)


HISTORY = {"rate": {"feed": "local"}, "unloading": {}, "relaxation": {"branches": [{"time": "2 s"}, {}]}}


def state_of(problem):
    """Everything a step may change."""
    fields = [field.x.array.copy() for field in problem.states.fields.values()]
    clock = [float(value.value) for value in (problem.clock.time_step, problem.clock.process_speed)]
    return [problem.displacement.x.array.copy(), *fields, problem.tip.value.copy(), clock, problem.coupling.gap()]


@pytest.mark.parametrize("laws", [{}, HISTORY], ids=["default", "with states"])
def test_a_forced_failure_restores_the_state_bit_for_bit(table, laws):
    problem, newton = build(table | {"laws": laws})
    for time, size in ((0.0, 0.0), (0.0, 1.0), (1.0, 1.5)):
        problem.begin(time, size)
        assert newton.solve().converged
        problem.commit(size)
    before, residual = state_of(problem), newton.evaluate_residual()

    newton.settings = newton.settings.model_copy(update={"max_iterations": 1})
    problem.begin(2.5, 5.0)
    outcome = newton.solve()
    assert not outcome.converged
    assert "did not converge" in outcome.reason
    assert not np.array_equal(problem.displacement.x.array, before[0])
    problem.rollback(2.5)

    for old, new in zip(before, state_of(problem), strict=True):
        assert np.array_equal(old, new)
    assert np.array_equal(residual, newton.evaluate_residual())
    for field in problem.states.fields.values():
        assert COMM.allreduce(int(np.ptp(field.x.array) > 0)) > 0  # the states did change before


@pytest.mark.serial
@pytest.mark.parametrize("modulus", [1e5, 2e6])
def test_the_printed_law_loses_stability_where_its_caution_says(modulus):
    """Real eigenvalues of a flat layer's tangent: positive up to a compaction of G_t / lambda, negative past it."""
    sides = dict.fromkeys(("x_min", "x_max", "y_min", "y_max"), "symmetry")
    stack = {"layers": 1, "size": ["40 mm", "2 mm"], "divisions": [20, 1], "grading": [0.0, 0.0], "sides": sides}
    laws = {"in_plane": {"kind": "as_printed"}, "shear": {"modulus": f"{modulus} Pa"}}
    table = {"duration": "1 s", "gravity": "0 m/s^2", "stack": stack, "laws": laws, "solver": {"tangent": "plain"}}
    problem, newton = build(table)
    critical = modulus / problem.scene.laws.in_plane.lame
    assert f"from a compaction of {100 * critical:.2g} % on" in problem.scene.laws.cautions[0]
    smallest = []
    for compaction in (0.97 * critical, 1.03 * critical):
        assign(problem, lambda x, e=compaction: np.stack([0 * x[0], 0 * x[0], -e * x[2]]))
        dense = newton.assemble_tangent().copy()
        dense.convert("dense")
        free = np.setdiff1d(np.arange(len(problem.displacement.x.array)), problem.supports.dofs)
        smallest.append(np.linalg.eigvals(dense.getDenseArray()[np.ix_(free, free)]).real.min())
    assert smallest[0] > 0 > smallest[1]


def test_bending_has_its_own_modulus_and_the_membrane_keeps_its_own(table):
    """Work of the fibres on a layer bent to a cylinder, and on one stretched, by their closed forms."""
    del table["tool"]
    laws = {
        "in_plane": {"modulus": "1 GPa", "poisson": 0.3},
        "shear": {"modulus": "1 Pa"},
        "compaction": {"kind": "power", "scale": "1 Pa", "exponent": 1},
    }
    table |= {"gravity": "0 m/s^2", "duration": "1 s", "stack": table["stack"] | {"layers": 1}}
    curvature, strain, t, area = 1e-3, 1e-6, 2e-3, 72e-6
    for modulus in (None, 10e6):
        bending = {} if modulus is None else {"bending": {"modulus": f"{modulus} Pa"}}
        problem, _ = build(table | {"laws": laws | bending})
        work = fem.form(ufl.action(problem.terms["internal"], problem.displacement))
        assign(problem, lambda x: np.stack([-curvature * x[0] * (x[2] - t / 2), 0 * x[0], curvature * x[0] ** 2 / 2]))
        rigidity = (modulus or 1e9) * t**3 / (12 * (1 - 0.3**2))
        bent = COMM.allreduce(fem.assemble_scalar(work))
        assert bent == pytest.approx(rigidity * curvature**2 * area, rel=1e-2 if modulus is None else 2e-2)
        assign(problem, lambda x: np.stack([strain * x[0], 0 * x[0], 0 * x[0]]))
        stretched = COMM.allreduce(fem.assemble_scalar(work))
        assert stretched == pytest.approx(1e9 / (1 - 0.3**2) * strain**2 * t * area, rel=1e-4)


def test_plies_of_each_layer_stiffen_their_own_layer(table):
    """Layers with fibres along x and along y, stretched along x: the fibres' work is in the first alone."""
    del table["tool"]
    families = {"kind": "fibre_families", "plies": [[0], [90]], "shear_modulus": "1 Pa", "modulus": "1 GPa"}
    table |= {
        "gravity": "0 m/s^2",
        "duration": "1 s",
        "laws": {"in_plane": families | {"modulus_compression": "1 GPa"}},
    }
    problem, _ = build(table)
    assign(problem, lambda x: np.stack([1e-5 * x[0], 0 * x[0], 0 * x[0]]))
    force = forces(fem.form(problem.terms["internal"]))[:, 0]
    x = problem.space.tabulate_dof_coordinates()
    end = np.isclose(x[:, 0], 12e-3)
    owned = np.arange(len(x)) < problem.space.dofmap.index_map.size_local
    lower = np.isclose(x[:, 2], 0.0)
    upper = np.isclose(x[:, 2], 4e-3)
    sums = [COMM.allreduce(float(force[end & owned & part].sum())) for part in (lower, upper)]
    assert sums[0] == pytest.approx(1e9 * 1e-5 * 6e-3 * 1e-3, rel=1e-3)  # half of a layer's section at its face
    assert abs(sums[1]) < 1e-4 * sums[0]


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
