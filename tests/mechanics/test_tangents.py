"""The tangent of every law: derivative, symmetry, objectivity, and what changes it."""

import numpy as np
import pytest
from assembled import COMM, assign, build, bumpy, forces, gradient_error, step_of
from dolfinx import fem

from ncf_fenicsx.mesh import compat

pytestmark = pytest.mark.two_ranks

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
    "relaxation by decades": SOFT | {"relaxation": {}},
    "rate table": SOFT | {"rate": {"kind": "table"}},
    "unloading": SOFT | {"unloading": {}},
    "set by pressure": SOFT | {"unloading": {"kind": "pressure_set", "reference_pressure": "1 kPa"}},
    "families": {"in_plane": FAMILIES},
    "plies of each layer": {"in_plane": FAMILIES | {"plies": [[0, 45], [90, 90, -30]]}},
    "bending": SOFT | {"bending": {"modulus": "0.1 MPa"}},
    "bending of families": {"in_plane": FAMILIES, "bending": {"modulus": "0.1 MPa"}},
    "bending table": SOFT | {"bending": {"kind": "table", "curvature": ["5 1/m", "50 1/m"], "moment": ["1 N", "5 N"]}},
    "two-sided bending table": SOFT
    | {"bending": {"kind": "table", "curvature": ["-9 1/m", "2 1/m", "60 1/m"], "moment": ["-5 N", "2 N", "6 N"]}},
    "shear table": SOFT | {"shear": {"kind": "table", "angle": [1, 5, 20], "stress": ["90 kPa", "200 kPa", "300 kPa"]}},
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
    step_of(problem).begin(0.0, 12.0)
    problem.clock.time_step.value, problem.clock.inverse_time_step.value = 0.5, 2.0
    problem.contacts.tools[0].tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    assign(problem, bumpy)
    for name, field in problem.states.items():
        if name.endswith("volume_fraction"):
            field.values[::2] *= 1.03  # half of the points have been denser before
        else:
            field.values[:] = 200.0
    return problem, newton


@pytest.mark.parametrize("name", LAWS)
def test_the_tangent_of_every_law_is_the_derivative_of_its_residual(table, name):
    problem, newton = strained(table, LAWS[name])
    assert gradient_error(problem, newton, 1e-9) < 1e-6


@pytest.mark.parametrize("name", LAWS)
def test_the_program_knows_which_tangents_are_symmetric(table, name):
    problem, newton = strained(table, LAWS[name])
    asymmetry = asymmetry_of(newton.tangent.assemble())
    assert problem.symmetric == (name not in ("as printed", "by volume"))
    assert newton.linear.factors.preconditioner.getType() == ("cholesky" if problem.symmetric else "lu")
    assert asymmetry < 1e-12 if problem.symmetric else asymmetry > 1e-7


def test_the_tangent_with_extrapolated_stress_is_symmetric_too(table):
    _, newton = strained(table, {}, "extrapolated")
    assert asymmetry_of(newton.tangent.assemble()) < 1e-12


def asymmetry_of(matrix):
    difference = matrix.copy()
    difference.axpy(-1.0, matrix.copy().transpose())
    return difference.norm() / matrix.norm()


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.serial
def test_forces_of_every_law_turn_with_the_body(table, name):
    """Objectivity: a rigid rotation by 90 degrees after a deformation turns the internal forces by as much."""
    problem, _ = strained(table, LAWS[name])
    form = compat.compile_form(problem.terms["internal"])
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    straight = forces(form)
    x = problem.space.tabulate_dof_coordinates()
    u = problem.displacement.x.array.reshape(-1, 3)
    u[:] = (x + u) @ turn.T - x
    assert np.abs(straight).max() > 1e-6
    assert forces(form) == pytest.approx(straight @ turn.T, abs=1e-10 * np.abs(straight).max())


@pytest.mark.parametrize("interface", ["one_sided", "bonded"])
def test_plain_tangent_is_the_derivative_of_the_residual(table, interface):
    table["solver"] = {"tangent": "plain"}
    table["interface"] = {"kind": interface}
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}  # so that round-off of the fibres hides nothing else
    table["tool"]["width"] = "7 mm"
    problem, newton = build(table)
    step_of(problem).begin(0.0, 12.0)
    problem.contacts.tools[0].tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    assign(problem, bumpy)
    if interface == "one_sided":
        gaps = COMM.allgather(problem.contacts.layers[0].gaps())
        assert np.concatenate(gaps).min() < 0 < np.concatenate(gaps).max()
    assert gradient_error(problem, newton, 1e-9) < 1e-6


def test_extrapolated_tangent_is_the_plain_one_where_the_iterates_agree_and_only_there(table):
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}
    problem, newton = build(table)
    step_of(problem).begin(0.0, 12.0)
    assign(problem, bumpy)
    problem.last_iterate.x.array[:] = problem.displacement.x.array
    assert gradient_error(problem, newton, 1e-9) < 1e-6
    problem.last_iterate.x.array[:] = 0
    assert gradient_error(problem, newton, 1e-9) > 1e-4


def symbols_of(law):
    """Names of a law's parameters with the constants that stand for them."""
    for name, value in law:
        for number, entry in enumerate(value) if isinstance(value, tuple) else [("", value)]:
            if isinstance(entry, fem.Constant):
                yield f"{law.kind}.{name}{number}", entry
            elif hasattr(entry, "model_fields"):
                yield from ((f"{law.kind}.{name}{number}.{key}", item) for key, item in entry)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.serial
def test_every_parameter_of_every_law_changes_the_tangent(table, name):
    problem, newton = strained(table, LAWS[name])
    material = problem.material
    laws = [material.law] if problem.scene.laws.solid is not None else material.laws.chosen
    before = newton.tangent.assemble().copy()
    count, idle = 0, {"exponential.smoothing"} if name != "clip" else set()
    if name not in ("clip", "raw"):
        idle.add("exponential.beta4")  # cancelled by the shift
    if name == "raw":
        idle |= {"kelly.alpha2", "kelly.v_ref", "kelly.reference_thickness"}  # tension, on which speed does not act
    for label, constant in (pair for law in laws for pair in symbols_of(law)):
        value = float(constant.value)
        constant.value = 1.01 * value + (0.01 if value == 0 else 0)
        difference = newton.tangent.assemble().copy()
        constant.value = value
        difference.axpy(-1.0, before)
        count += 1
        assert (difference.norm() > 1e-12 * before.norm()) == (label not in idle), label
    assert count >= (2 if "solid" in name else 8)


@pytest.mark.parametrize(
    "change",
    [
        {"laws": {"in_plane": {"modulus": "2 MPa"}}},
        {"laws": {"in_plane": {"modulus": "1 MPa", "poisson": 0.4}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "compaction": {"beta2": 1.6}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "rate": {"alpha1": 0.5}}},
        {"laws": {"in_plane": {"modulus": "1 MPa"}, "shear": {"modulus": "1 MPa"}}},
        {"interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0, "penalty": 20.0}},
        {"interface": {"kind": "stitched", "yarn_stiffness": "10 N", "slip_share": 0.0}},
        {"interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 100.0}},
        {"tool": {"width": "infinite", "penalty": 20.0}},
        {"tool": {"width": "infinite", "radius": "200 mm"}},
    ],
)
@pytest.mark.serial
def test_every_parameter_changes_the_tangent(table, change):
    table["laws"] = {"in_plane": {"modulus": "1 MPa"}}
    norms = []
    for made in (table, table | change):
        problem, newton = build(made)
        step_of(problem).begin(0.0, 12.0)
        problem.contacts.tools[0].tip.value[2] = 3.6e-3
        assign(problem, bumpy)
        norms.append(newton.tangent.assemble().norm())
    assert abs(norms[1] / norms[0] - 1) > 1e-7


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
    assert f"from a compaction of {100 * critical:.2g} % on" in problem.scene.cautions[0]
    smallest = []
    for compaction in (0.97 * critical, 1.03 * critical):
        assign(problem, lambda x, e=compaction: np.stack([0 * x[0], 0 * x[0], -e * x[2]]))
        dense = newton.tangent.assemble().copy()
        dense.convert("dense")
        free = np.setdiff1d(np.arange(len(problem.displacement.x.array)), problem.supports.dofs)
        smallest.append(np.linalg.eigvals(dense.getDenseArray()[np.ix_(free, free)]).real.min())
    assert smallest[0] > 0 > smallest[1]
