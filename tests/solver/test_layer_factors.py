"""Factors of each layer and of all heights: a good guess of the inverse, made exact; stability told from below."""

import json

import numpy as np
import pytest
from assembled import assign, build, bumpy, layer_factors, run_with_factors, tangent_of
from mpi4py import MPI

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.simulation import run
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.layer_factors import ALONE, LayerFactors
from ncf_fenicsx.solver.linear_solver import LinearSolver

WAYS = {
    "open interfaces": {},
    "stitches": {"interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.1}},
    "friction": {"interface": {"friction": {"coefficient": 0.3}}},
    "layers of other meshes": {"stack": {"divisions": [[6, 2], [8, 3]]}},
    "a bonded pair": {"stack": {"layers": 3}, "interface": [{"kind": "bonded"}, {"kind": "one_sided"}]},
    "several elements through each": {"stack": {"through": 2}},
}


def scene_table(table, change):
    return table | change | {"stack": table["stack"] | change.get("stack", {})}


@pytest.mark.parametrize("way", WAYS)
def test_a_few_krylov_steps_solve_for_a_motion_of_the_stack(table, way):
    newton, matrix, wanted, load = tangent_of(scene_table(table, WAYS[way]))
    linear, found = LinearSolver(layer_factors(newton), keeps=False), load.duplicate()
    assert linear.factorise(matrix) == 0
    assert linear._iterate(matrix, load, found)
    found.axpy(-1.0, wanted)
    assert found.norm() < 0.01 * wanted.norm()
    assert 0 < linear.krylov_steps <= 60


def test_a_correction_that_others_follow_takes_fewer_steps(table):
    newton, matrix, wanted, load = tangent_of(table)
    steps, errors = [], []
    for last in (False, True):
        linear, found = LinearSolver(layer_factors(newton), keeps=False), load.duplicate()
        linear.factorise(matrix)
        linear.expect(last, exact=False)
        assert linear._iterate(matrix, load, found)
        found.axpy(-1.0, wanted)
        steps.append(linear.krylov_steps)
        errors.append(found.norm() / wanted.norm())
    assert steps[0] < steps[1]
    assert 0.1 > errors[0] > 10 * errors[1]


@pytest.fixture(scope="module")
def bent(tmp_path_factory):
    """Records of a roller on four layers that resist bending, by the factors; "no columns" are those of layers only."""
    table = {
        "stack": {"layers": 4, "thickness": "2 mm", "size": ["76 mm", "76 mm"], "divisions": [8, 8], "grading": [0, 0]}
        | {"sides": {"x_min": "symmetry", "y_min": "symmetry"}},
        "laws": {"bending": {"modulus": "0.1 GPa"}, "shear": {"modulus": "2 MPa"}},
        "interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0},
        "tool": {"width": "30 mm", "path": [{"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}]},
        "output": {"picture": False, "report": False},
    }
    folder, records = MPI.COMM_WORLD.bcast(tmp_path_factory.mktemp("bent")), {}
    with pytest.MonkeyPatch.context() as patch:
        for name in ("new", "layers", "no columns"):
            if name == "no columns":
                patch.setattr("ncf_fenicsx.solver.layer_factors.motions_of_columns", lambda *_: None)
            factors = {"factors": "layers" if name == "no columns" else name, "force_tolerance": 1e-4}
            result = run(Scene.from_table(table | {"solver": factors}), folder / name)
            assert result.done, result.reason
            records[name] = json.loads((folder / name / "run.json").read_text("utf-8"))
            records[name]["solves"] = sum(row["newton_iterations"] > 0 for row in result.history)
    return records


def test_layers_take_the_iterations_of_factors_of_the_whole(bent):
    """A correction that leaves stiff fibres strained by a thousandth of it led to three times as many."""
    assert bent["layers"]["newton_iterations"] <= bent["new"]["newton_iterations"] + 2


def test_factors_of_layers_are_kept_from_correction_to_correction(bent):
    """A solve begins with new ones. Those of the heights follow contact: so it takes hardly more Krylov steps."""
    assert bent["layers"]["step_cuts"] == 0
    assert bent["layers"]["factorisations"] == bent["layers"]["solves"]
    assert bent["layers"]["solves"] < 0.5 * bent["layers"]["newton_iterations"]
    assert bent["layers"]["krylov_steps"] <= 6 * bent["layers"]["newton_iterations"]


@pytest.mark.two_ranks
def test_heights_that_follow_contact_save_krylov_steps(table):
    newton, _, _, load = tangent_of(table)
    steps = []
    for follows in (False, True):
        linear, found = LinearSolver(layer_factors(newton), keeps=True), load.duplicate()
        assign(newton.system, lambda x: -1e-7 * x)
        linear.factorise(newton.tangent.assemble())
        assign(newton.system, bumpy)
        changed = newton.tangent.assemble()
        if follows:
            assert linear.factors.renew(changed) == 0
        assert linear._iterate(changed, load, found) or not follows
        steps.append(linear.krylov_steps)
    assert 0 < steps[1] < steps[0]


def test_what_layers_do_alike_takes_krylov_steps_away(bent):
    assert 0 < bent["layers"]["krylov_steps"] < 0.8 * bent["no columns"]["krylov_steps"]


@pytest.mark.two_ranks
def test_columns_join_after_a_slow_correction_alone(table):
    newton, matrix, _, load = tangent_of(table)
    factors, found = layer_factors(newton), load.duplicate()
    for applications, joined in ((ALONE, False), (ALONE + 1, True)):
        assert factors.factorise(matrix) == 0
        for _ in range(applications):
            factors.preconditioner.apply(load, found)
        assert factors.renew(matrix) == 0
        assert (factors._columns is not None) == joined


def test_the_search_for_a_mode_is_no_slow_correction(table, monkeypatch):
    applied, calls = LayerFactors.apply, []
    monkeypatch.setattr(LayerFactors, "apply", lambda self, *args: calls.append(applied(self, *args)))
    problem, newton = build(table)
    assign(problem, lambda x: -1e-7 * x)
    matrix = newton.tangent.assemble()
    factors = layer_factors(newton)
    for _ in range(2):
        assert factors.factorise(matrix) == 0
        for _ in range(ALONE):
            assert factors.count_negative(matrix) == 0
    assert len(calls) > 2 * ALONE
    assert factors._columns is None


@pytest.mark.parametrize("strain", [0.0, 1e-3])
def test_pivots_of_the_parts_tell_of_a_loss_of_stability_and_are_no_more_than_the_whole_has(strain):
    """Two sheets on weak ground, stable at rest, their ends pressed towards each other."""
    problem, newton = build(
        {
            "stack": {"layers": 2, "size": ["24 mm", "2 mm"], "divisions": [24, 1], "grading": [0, 0]},
            "laws": {"in_plane": {"modulus": "1e9 Pa"}, "bending": {"modulus": "1 Pa"}, "shear": {"modulus": "1e5 Pa"}},
            "duration": "1 s",
        }
    )
    assign(problem, lambda x: np.stack([-strain * x[0], 0 * x[0], -1e-7 * x[2]]))
    matrix, parts, whole = newton.tangent.assemble(), layer_factors(newton), DirectFactors(newton.vector.comm, True)
    assert parts.factorise(matrix) == whole.factorise(matrix) == 0
    assert parts.count_negative(matrix) <= whole.count_negative(matrix)
    assert (parts.count_negative(matrix) > 0) == (whole.count_negative(matrix) > 0) == (strain > 0)


@pytest.mark.parametrize("strain", [-1e-4, 0.0, 1e-4])
def test_layers_that_buckle_together_are_found_though_each_is_held_by_the_others(strain):
    """A long stack that nothing holds from below, and whose contacts are stiff, its ends pressed towards each other."""
    problem, newton = build(
        {
            "stack": {"layers": 2, "size": ["200 mm", "2 mm"], "divisions": [40, 1], "grading": [0, 0]}
            | {"sides": {"x_min": "fixed", "x_max": "free", "y_max": "symmetry"}},
            "laws": {
                "in_plane": {"modulus": "1e9 Pa", "poisson": 0.0},
                "bending": {"modulus": "1e6 Pa"},
                "shear": {"modulus": "1e7 Pa"},
                "compaction": {"kind": "power", "scale": "1e8 Pa", "exponent": 1},
            },
            "interface": {"penalty": "1e11 Pa/m"},
            "mould": {"kind": "plate", "clearance": "50 mm"},
            "gravity": "0 m/s^2",
            "duration": "1 s",
        }
    )
    assign(problem, lambda x: np.stack([-strain * x[0], 0 * x[0], -1e-7 * x[2]]))
    matrix, parts, whole = newton.tangent.assemble(), layer_factors(newton), DirectFactors(newton.vector.comm, True)
    assert parts.factorise(matrix) == whole.factorise(matrix) == 0
    assert max(factors.count_negative(matrix) for factors in parts._factors) == 0, "no part tells"
    assert parts.count_negative(matrix) == (strain > 0) == (whole.count_negative(matrix) > 0)


def test_parts_of_a_singular_tangent_are_told(table):
    newton, matrix, _, _ = tangent_of(table)
    matrix.zeroEntries()
    assert LinearSolver(layer_factors(newton), keeps=False).factorise(matrix) != 0


@pytest.mark.parametrize("force", [pytest.param(False, marks=pytest.mark.two_ranks), True])
def test_a_run_ends_in_the_same_state(table, folder, force):
    if force:
        table["tool"]["path"] = [{"hold": "10 s", "force": "0.1 N"}]
    parts, whole = (run_with_factors(table, way, folder) for way in ("layers", "new"))
    for name in ("tool_force", "vf_max", "vf_mean", "void_volume_1"):
        assert parts[0][name] == pytest.approx(whole[0][name], rel=1e-4), name
    assert parts[1]["krylov_steps"] > 0 == whole[1]["krylov_steps"]
    assert parts[1]["newton_iterations"] == pytest.approx(whole[1]["newton_iterations"], abs=5)


def test_a_stack_that_cannot_part_is_refused(table):
    with pytest.raises(SceneError, match=r"solver\.factors = 'layers'.*layers that may part"):
        Scene.from_table(table | {"interface": {"kind": "bonded"}, "solver": {"factors": "layers"}})
