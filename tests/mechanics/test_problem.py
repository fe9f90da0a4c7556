"""The assembled equation: what is built, trial and committed state, bending, plies, pairs."""

import re

import numpy as np
import pytest
import ufl
from assembled import COMM, assign, build, forces, step_of
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from laws_by_number import VF0, strained
from petsc4py import PETSc

from ncf_fenicsx.laws.law import number
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.output.measures import Measures

pytestmark = pytest.mark.two_ranks

SUM = PETSc.Mat.InfoType.GLOBAL_SUM


def test_a_scene_builds_only_what_it_names(table):
    problem, newton = build(table)
    assert set(problem.terms) == {"internal", "gravity", "tool", "interface"}
    assert set(problem.states) == {"volume_fraction"}
    assert not problem.face_states
    pairs = len(problem.contacts.layers[0].pairing.masters)
    assert pairs == 7 * 3
    entries = newton.tangent.matrix.getInfo(SUM)["nz_used"]

    bare = {key: table[key] for key in ("stack",)} | {"duration": "1 s", "gravity": "0 m/s^2"}
    alone, _ = build(bare | {"interface": {"kind": "bonded"}})
    assert set(alone.terms) == {"internal"}
    assert not alone.contacts.layers
    assert not alone.contacts.rigid
    assert alone.space.dofmap.index_map.size_global < problem.space.dofmap.index_map.size_global

    separate, newton_separate = build(bare | {"solver": {"tangent": "plain"}})
    assert separate.last_iterate is None
    # contact with a tool adds nothing to the pattern
    assert newton_separate.tangent.matrix.getInfo(SUM)["nz_used"] == entries
    pattern = fem_petsc.create_matrix(separate.tangent_form).getInfo(SUM)["nz_allocated"]
    assert entries - pattern == 2 * 9 * pairs


@pytest.mark.parametrize(
    ("ways", "memory", "face_states"),
    [
        ({}, [], False),
        ({"contact": {"kind": "augmented_lagrangian"}}, ["multiplier", "penalty_factor"], False),
        ({"friction": {"coefficient": 0.2}}, ["traction"], False),
        ({"contact": {"kind": "nitsche"}}, [], True),
    ],
)
def test_contact_keeps_only_what_its_ways_need(table, ways, memory, face_states):
    table |= {"tool": table["tool"] | ways, "interface": {"kind": "one_sided"} | ways}
    problem, _ = build(table)
    names = [field.name for field in problem.contacts.state]
    tool, interface = (
        [name.partition(".")[2] for name in names if name.startswith(of)] for of in ("tool.", "interface.")
    )
    assert tool == ["height_offset", "active_set", *memory]
    assert interface == ["slip", *memory]
    assert bool(problem.face_states) == face_states
    assert problem.symmetric == (not face_states and "friction" not in ways)
    assert not problem.contacts.controls


def coefficients(problem):
    """Fields that the laws are compiled with, beside the displacement."""
    return len(problem.terms["internal"].coefficients()) - 1


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
        (NO_RATE | {"relaxation": {"branches": [{}]}}, {"volume_fraction", "relaxing_pressure_1"}, 2, 1),
        (NO_RATE | {"shear": {"kind": "table"}}, {"volume_fraction"}, 0, 1),
        (NO_RATE | {"in_plane": {"kind": "fibre_families"}}, {"volume_fraction"}, 0, 1),
        (NO_RATE | {"in_plane": {"kind": "fibre_families", "plies": [[0], [90]]}}, {"volume_fraction"}, 2, 1),
        (NO_RATE | {"bending": {}}, {"volume_fraction"}, 0, 5),
        (NO_RATE | {"bending": {"kind": "table"}}, {"volume_fraction"}, 0, 5),
        ({"solid": {}}, set(), 0, 2),
        ({"solid": {"volume_integration": "full"}}, set(), 0, 1),
    ],
)
def test_a_law_that_is_not_named_has_no_state_no_field_and_no_integral(table, laws, states, fields, integrals):
    problem, _ = build(table | {"laws": laws})
    assert set(problem.states) == states
    assert coefficients(problem) == fields
    assert rules(problem) == integrals
    assert (problem.last_iterate is None) == ("solid" in laws)


HISTORY = {"rate": {"feed": "local"}, "unloading": {}, "relaxation": {"branches": [{"time": "2 s"}, {}]}}


def state_of(problem):
    """Everything a step may change."""
    fields = [field.values.copy() for field in problem.states.values()]
    clock = [float(value.value) for value in (problem.clock.time_step, problem.clock.process_speed)]
    return [
        problem.displacement.x.array.copy(),
        *fields,
        problem.contacts.tools[0].tip.value.copy(),
        clock,
        problem.contacts.layers[0].gaps(),
    ]


@pytest.mark.parametrize("laws", [{}, HISTORY], ids=["default", "with states"])
def test_a_forced_failure_restores_the_state_bit_for_bit(table, laws):
    problem, newton = build(table | {"laws": laws, "solver": {"time_tolerance": 1.0}})
    step = step_of(problem, newton)
    for time, size in ((0.0, 0.0), (0.0, 1.0), (1.0, 1.5)):
        assert step.attempt(time, size).converged
        step.commit()
    before, residual = state_of(problem), newton.evaluate_residual()

    newton.convergence.settings = newton.settings.model_copy(update={"max_iterations": 1})
    step.begin(2.5, 5.0)
    outcome = newton.solve()
    assert not outcome.converged
    assert "did not converge" in outcome.reason
    assert not np.array_equal(problem.displacement.x.array, before[0])
    step.rollback(2.5)

    for old, new in zip(before, state_of(problem), strict=True):
        assert np.array_equal(old, new)
    assert np.array_equal(residual, newton.evaluate_residual())
    for field in problem.states.values():
        assert COMM.allreduce(int(np.ptp(field.values) > 0)) > 0  # the states did change before


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

    def bend(x):
        return np.stack([-curvature * x[0] * (x[2] - t / 2), 0 * x[0], curvature * x[0] ** 2 / 2])

    for modulus in (None, 10e6):
        bending = {} if modulus is None else {"bending": {"modulus": f"{modulus} Pa", "poisson": 0.3}}
        problem, _ = build(table | {"laws": laws | bending})
        rigidity = (modulus or 1e9) * t**3 / (12 * (1 - 0.3**2))
        assert work_of(problem, bend) == pytest.approx(rigidity * curvature**2 * area, rel=1e-2)
        stretched = work_of(problem, lambda x: np.stack([strain * x[0], 0 * x[0], 0 * x[0]]))
        assert stretched == pytest.approx(1e9 / (1 - 0.3**2) * strain**2 * t * area, rel=1e-4)


def work_of(problem, field):
    """Virtual work in J of the internal forces on the displacement itself: twice the energy, where it is quadratic."""
    assign(problem, field)
    return COMM.allreduce(
        fem.assemble_scalar(compat.compile_form(ufl.action(problem.terms["internal"], problem.displacement)))
    )


@pytest.mark.parametrize("strain", [-1e-3, 0.0, 1e-3])
@pytest.mark.parametrize("in_plane", [{"kind": "fibre_families"}, {"kind": "fibre_families", "plies": [0]}, {}])
def test_rigidity_in_bending_does_not_follow_the_fibres(table, in_plane, strain):
    """Second derivative of the work over curvature, of layers stretched and compressed before they are bent."""
    del table["tool"]
    stack = table["stack"] | {"layers": 1}
    laws = {"in_plane": in_plane, "bending": {"modulus": "1 GPa"}, "shear": {"modulus": "1 Pa"}}
    laws |= {"compaction": {"kind": "power", "scale": "1 Pa", "exponent": 1}}
    problem, _ = build({"gravity": "0 m/s^2", "duration": "1 s", "stack": stack, "laws": laws})
    assign(problem, lambda x: np.stack([strain * x[0], 0 * x[0], 0 * x[0]]))
    bent = fem.Function(problem.space)
    bent.interpolate(
        lambda x: np.stack([-x[0] * (x[2] - 1e-3), 0 * x[0], 0 * x[0]])
    )  # no deflection: no membrane force
    tangent = ufl.derivative(problem.terms["internal"], problem.displacement, bent)
    rigidity = COMM.allreduce(fem.assemble_scalar(compat.compile_form(ufl.action(tangent, bent)))) / 72e-6
    assert rigidity == pytest.approx(1e9 * 8e-9 / (12 * (1 - 0.2**2)), rel=1e-2)


def test_the_normal_stress_is_that_of_the_whole_energy(table):
    """stress_33 of a layer stretched, sheared and pressed, against n . sigma n by differences of the laws' energies."""
    del table["tool"]
    laws = {"shear": {"kind": "growing", "modulus": "1 MPa"}, "rate": {"kind": "none"}}
    problem, _ = build(table | {"duration": "1 s", "laws": laws, "interface": {"kind": "bonded"}})
    F = np.array([[1.03, 0.01, 0.08], [0.0, 0.98, -0.05], [0.02, 0.01, 0.85]])
    assign(problem, lambda x: (F - np.eye(3)) @ x)
    measures = Measures(problem)
    measures.observe(np.zeros(3 * problem.contacts.body.spaces.owned), 0.0)
    made = problem.scene.laws

    def energy(F):
        kinematics = strained(F)
        vf = number(kinematics.volume_fraction)
        return made.compaction.energy(vf, VF0) + number(made.shear.energy(kinematics))

    normal = np.linalg.inv(F).T @ [0, 0, 1]
    stretch = np.linalg.det(F) * np.linalg.norm(normal)
    normal, step = normal / np.linalg.norm(normal), 1e-6
    push = step * np.outer(normal, [0, 0, 1])
    expected = (energy(F + push) - energy(F - push)) / (2 * step) / stretch
    assert abs(expected) > 1e3
    assert measures.cells["stress_33"] == pytest.approx(expected, rel=1e-6)


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
    force = forces(compat.compile_form(problem.terms["internal"]))[:, 0]
    x = problem.space.tabulate_dof_coordinates()
    end = np.isclose(x[:, 0], 12e-3)
    owned = np.arange(len(x)) < problem.space.dofmap.index_map.size_local
    lower = np.isclose(x[:, 2], 0.0)
    upper = np.isclose(x[:, 2], 4e-3)
    sums = [COMM.allreduce(float(force[end & owned & part].sum())) for part in (lower, upper)]
    assert sums[0] == pytest.approx(1e9 * 1e-5 * 6e-3 * 1e-3, rel=1e-3)  # half of a layer's section at its face
    assert abs(sums[1]) < 1e-4 * sums[0]


@pytest.mark.parametrize("laws", [{}, {"solid": {"kind": "split"}}], ids=["fabric", "solid"])
def test_an_inverted_element_is_named_with_its_place(table, laws):
    problem, _ = build(table | {"laws": laws, "interface": {"kind": "bonded"}})
    assert problem.admissibility.violation() is None
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], np.where((x[0] > 11e-3) & (x[2] > 3e-3), -5e-3, 0)]))
    words = problem.admissibility.violation()
    assert words.startswith("inverted elements, volume ratio J at ")
    assert re.search(r"such as -\d.* at \(1[01].*\) mm in layer 2", words)


def test_a_volume_fraction_of_one_is_no_state(table):
    problem, _ = build(table)
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], -0.7 * x[2]]))
    assert "fibre volume fraction outside (0, 1)" in problem.admissibility.violation()


def test_closed_and_open_pairs_push_and_pull(table):
    """Layers pressed together by 1 um carry the penalty; pulled apart by 1 um only the stitching."""
    table["interface"] = {"kind": "stitched", "penalty": "1e9 Pa/m", "yarn_stiffness": "0.01 N", "slip_share": 0.0}
    problem, _ = build(table)
    area = 12e-3 * 6e-3
    upper = problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3
    layer = problem.contacts.layers[0]
    above = np.isin(problem.contacts.body.spaces.numbers, layer.pairing.masters) | upper
    for lift, stiffness in ((-1e-6, 1e9), (1e-6, 1e5)):
        problem.displacement.x.array[:] = 0
        problem.displacement.x.array.reshape(-1, 3)[above, 2] = lift
        layer.refresh()
        force = COMM.allreduce(float(layer.residual()[1][:, 2].sum()))
        assert force == pytest.approx(stiffness * lift * area, rel=1e-12)
