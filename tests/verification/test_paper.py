"""What the paper prints and what it must mean, row by row: every figure, and both options."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from laws_by_number import MM_PER_MIN, VF0, in_step, numbers, strained
from mpi4py import MPI
from program import DEMOS

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.in_plane import NeoHookean, NeoHookeanAsPrinted
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.rate import KellyRate
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.solver.timing import Phases

pytestmark = pytest.mark.serial


# Vf0 and Eq. 5


def test_initial_volume_fraction_of_the_paper():
    assert pytest.approx(0.398045, abs=5e-7) == VF0


def test_the_volume_fraction_of_equation_5():
    """Vf0 exp(eps), eps = -ln lambda_3; with 0.5 mm off 8 mm uniformly it is 0.42458."""
    stretch = 7.5 / 8
    vf = number(strained(np.diag([1, 1, stretch])).volume_fraction)
    assert vf == pytest.approx(VF0 * np.exp(-np.log(stretch)), rel=1e-12)
    assert vf == pytest.approx(0.42458, abs=5e-6)


# Eq. 4: the exponent of the rate law


@pytest.mark.parametrize(
    ("speed", "growth", "kpa"),
    [(0, 1.0, 25.28), (0.5, 1.01138, 25.57), (1, 1.10020, 27.82), (2, 1.65887, 41.95), (5, 3.05293, 77.20)],
)
def test_rate_factor_and_stress_at_vf_60(speed, growth, kpa):
    rate = KellyRate()
    assert rate.growth(speed * MM_PER_MIN) == pytest.approx(growth, abs=5e-6)
    assert rate.factor(speed * MM_PER_MIN) * Exponential().as_printed(0.6) / 1e3 == pytest.approx(kpa, abs=1e-2)


@pytest.mark.parametrize(
    ("speed", "growth"), [(0, 3.2355), (1, 3.2203), (2, 3.1069), (3, 2.8370), (5, 1.8463), (10, -2.891)]
)
def test_rate_factor_as_printed(speed, growth):
    assert KellyRate(exponent="as_printed").growth(speed * MM_PER_MIN) == pytest.approx(growth, abs=5e-4)


def test_rate_growth_has_the_limits_the_paper_defines():
    rate = KellyRate()
    assert rate.growth(0.0) == pytest.approx(1.0, rel=1e-12)
    assert rate.growth(1e6) == pytest.approx(85829 / 23726, rel=1e-6)
    assert rate.factor(rate.v_ref) == 1.0


def test_the_printed_factor_is_refused_where_it_is_negative():
    table = {"laws": {"rate": {"exponent": "as_printed", "feed": "process"}}}
    path = [{"travel": ["0 mm", "0 mm", "-1 mm"], "speed": "10 mm/min"}]
    with pytest.raises(SceneError, match=r"laws.rate.exponent = 'as_printed': expected a positive factor"):
        Scene.from_table(table | {"tool": {"path": path}})
    assert "negative above 7." in Scene.from_table(table | {"tool": {}}).cautions[0]


# Eq. 2: both factors hold the level of 2 mm/min


def test_normalised_at_the_lowest_speed_the_level_of_the_fit_counts_twice():
    factor = KellyRate(normalised="lowest_speed").factor(2 * MM_PER_MIN)
    assert factor * Exponential().as_printed(0.6) / 1e3 == pytest.approx(69.6, abs=0.05)


# Eq. 3: the tensile toe


@pytest.mark.parametrize(
    ("vf", "kpa"),
    [
        (0.398045, -0.9618),
        (0.41, -0.6612),
        (0.423, -0.2546),
        (0.43, 0.0058),
        (0.45, 0.9523),
        (0.466, 1.9877),
        (0.50, 5.4339),
        (0.55, 16.1798),
        (0.60, 41.9459),
        (0.65, 103.727),
    ],
)
def test_the_printed_curve(vf, kpa):
    assert Exponential(toe="raw").pressure(vf, VF0) / 1e3 == pytest.approx(kpa, abs=1e-3)
    assert Exponential().as_printed(vf) / 1e3 == pytest.approx(kpa, abs=1e-3)


def test_the_printed_fabric_shrinks_by_itself_and_the_shifted_one_does_not(folder):
    """A free layer comes to rest where its stress is zero: 0.59 mm lower in a stack of 8 mm."""
    rest = {}
    for toe in ("raw", "shift"):
        table = {"duration": "1 s", "gravity": "0 m/s^2", "laws": {"compaction": {"toe": toe}}}
        table |= {
            "stack": {"layers": 1, "size": ["4 mm", "4 mm"], "divisions": [1, 1]},
            "output": {"picture": False, "report": False},
        }
        rest[toe] = run(Scene.from_table(table), folder / toe).history[-1]["vf_mean"]
    assert rest["raw"] == pytest.approx(0.429852, abs=1e-6)
    assert 8 * (1 - VF0 / rest["raw"]) == pytest.approx(0.592, abs=1e-3)
    assert rest["shift"] == pytest.approx(VF0, rel=1e-12)


# Eq. 1: the three-dimensional J in the fibres' plane


def test_compaction_presses_the_fibres_as_printed_and_leaves_them_alone_by_default():
    """6.25 % compaction: -8.7 GPa in the plane by the printed law, nothing by the default."""
    pressed = strained(np.diag([1, 1, 1 - 0.0625]))
    stress = numbers(NeoHookeanAsPrinted().stress(pressed)) / (1 - 0.0625)  # Cauchy: the area is as it was
    assert stress == pytest.approx(-8.725e9 * np.eye(2), rel=1e-3)
    assert numbers(NeoHookean().stress(pressed)) == pytest.approx(np.zeros((2, 2)))


def test_newton_dies_at_four_hundredths_of_a_millimetre_as_printed(folder):
    scene = Scene.read(DEMOS / "long_roller.toml", ["laws.in_plane={kind='as_printed'}", "solver.smallest_step=0.1 s"])
    result = run(scene, folder)
    assert not result.done
    assert 0.01e-3 < result.history[-1]["tool_displacement"] < 0.08e-3


# no transverse shear


@pytest.mark.parametrize("modulus", [1e-6, 1e5])
def test_nothing_but_transverse_shear_resists_a_slide_of_a_layers_faces(modulus):
    """Without it, as printed, columns of the layer slide freely: work of a slide g over volume is G_t g^2."""
    table = {"duration": "1 s", "gravity": "0 m/s^2", "interface": {"kind": "bonded"}}
    table |= {"stack": {"layers": 1, "size": ["4 mm", "4 mm"], "divisions": [2, 2]}}
    scene = Scene.from_table(table | {"laws": {"shear": {"modulus": f"{modulus} Pa"}}})
    problem = Problem(scene, build_mesh(scene, MPI.COMM_SELF))
    problem.displacement.interpolate(lambda x: np.stack([1e-2 * x[2], 0 * x[0], 0 * x[0]]))
    work = fem.assemble_scalar(fem.form(ufl.action(problem.terms["internal"], problem.displacement)))
    assert work / (4e-3 * 4e-3 * 2e-3) == pytest.approx(modulus * 1e-4, rel=1e-6, abs=1e-3)


# free layers


def smallest_eigenvalue(overrides, lift=0.0):
    """Of the tangent of two small layers, the upper one lifted, over its largest."""
    sides = dict.fromkeys(("x_min", "x_max", "y_min", "y_max"), "symmetry")
    stack = {"layers": 2, "size": ["4 mm", "4 mm"], "divisions": [2, 2], "sides": sides}
    scene = Scene.from_table(
        {"duration": "1 s", "stack": stack, "laws": {"in_plane": {"modulus": "1 MPa"}}} | overrides
    )
    problem = Problem(scene, build_mesh(scene, MPI.COMM_SELF))
    heights = problem.space.tabulate_dof_coordinates()[:, 2]
    raised = np.union1d(problem.contacts.layers[0].pairing.masters, np.flatnonzero(heights > 2.1e-3))
    problem.displacement.x.array.reshape(-1, 3)[raised, 2] = lift
    dense = Newton(problem, scene.solver, Phases()).tangent.assemble().copy()
    dense.convert("dense")
    free = np.setdiff1d(np.arange(len(problem.displacement.x.array)), problem.supports.dofs)
    values = np.linalg.eigvalsh(dense.getDenseArray()[np.ix_(free, free)])
    return values[0] / values[-1]


def test_an_open_layer_is_singular_without_stitching():
    stitched = {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0}
    ratios = [smallest_eigenvalue({"interface": way}, lift=1e-6) for way in ({}, stitched)]
    assert abs(ratios[0]) < 1e-14
    assert ratios[1] > 1e-8


def test_the_weight_of_a_layer_is_14_pascal():
    stack = Scene.from_table({"duration": "1 s"}).stack
    assert stack.areal_density * 9.81 == pytest.approx(14.0, abs=0.03)


# the speed of the cross-head


def test_the_speed_of_the_process_is_not_that_of_the_fabric():
    """1 mm/min over 8 mm: the fabric closes as a specimen of 4 mm does at half that speed; as printed at 1 mm/min."""
    closed = 0.5e-3 / 8e-3
    vf, before = VF0 / (1 - closed), VF0 / (1 - 0.99 * closed)
    duration = 0.01 * 0.5e-3 / MM_PER_MIN
    step = in_step(Exponential(), vf, before, time_step=duration, process_speed=MM_PER_MIN)
    assert number(KellyRate(feed="local").speed(step)) == pytest.approx(0.5 * MM_PER_MIN, rel=1e-9)
    assert KellyRate(feed="process").speed(step) == MM_PER_MIN
