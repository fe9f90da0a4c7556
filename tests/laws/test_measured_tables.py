"""Laws given by tables of measurements: what they give back, where they are smooth, and what is refused."""

import numpy as np
import pytest
import ufl
from laws_by_number import (
    DEFORMATIONS,
    EXPONENTIAL,
    MM_PER_MIN,
    TURN,
    VF0,
    in_step,
    law,
    loading,
    march,
    rows,
    strained,
)
from scipy.integrate import quad

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.monotone_cubic import MonotoneCubic
from ncf_fenicsx.laws.rate import KellyRate

pytestmark = pytest.mark.serial

X, Y = (-1.0, 0.5, 1.0, 4.0), (-3.0, 0.1, 2.0, 2.5)
CURVES = {
    "straight": MonotoneCubic.through(X, Y),
    "level": MonotoneCubic.through(X, Y, "level"),
    "odd": MonotoneCubic.from_origin(X[1:], Y[1:]),
}


@pytest.mark.parametrize("name", CURVES)
def test_a_curve_meets_its_nodes_rises_and_has_no_corner(name):
    curve = CURVES[name]
    assert curve(np.array(curve.x)) == pytest.approx(curve.y, abs=1e-14)
    at = np.linspace(curve.x[0] - (name != "odd"), 6, 60001)
    assert np.all(np.diff(curve(at)) >= -1e-15)
    slope = np.gradient(curve(at), at)
    assert np.abs(np.diff(slope)).max() < 5e-3
    assert (slope[-2] == pytest.approx(0, abs=1e-9)) == (name == "level")


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("at", [0.2, 0.5, 0.7, 3.0, 5.0])
def test_symbols_and_areas_are_those_of_the_numbers(name, at):
    curve = CURVES[name]
    assert number(curve(ufl.as_ufl(at))) == pytest.approx(float(curve(at)), rel=1e-14)
    area, _ = quad(curve, curve.x[0], at, points=[x for x in curve.x if curve.x[0] < x < at] or None)
    assert float(curve.integral(at)) == pytest.approx(area, rel=1e-9)
    assert number(curve.integral(ufl.as_ufl(at))) == pytest.approx(area, rel=1e-9)


def test_the_shear_table_gives_back_what_was_measured():
    made = law("shear", "table")
    for angle, stress in zip(made.angle, made.stress, strict=True):
        slide, step = np.tan(np.radians(angle)), 1e-7
        energies = []
        for sign in (-1, 1):
            F = np.eye(3)
            F[0, 2] = slide + sign * step
            energies.append(number(made.energy(strained(F))))
        assert np.diff(energies)[0] / (2 * step) == pytest.approx(stress, rel=1e-4)
    assert made.small_strain_modulus == pytest.approx(3.7e3 / np.tan(np.radians(0.023)), rel=1e-3)
    assert made.shear_stress(np.tan(np.radians(7.0))) / np.tan(np.radians(7.0)) == pytest.approx(0.504e6, rel=1e-3)


def test_the_energy_of_sheared_fabric_does_not_see_a_rotation():
    made = law("shear", "table")
    for F in DEFORMATIONS:
        assert number(made.energy(strained(TURN @ F))) == pytest.approx(number(made.energy(strained(F))), rel=1e-10)


def bent(made, kappa):
    return number(made.energy_per_area(ufl.as_matrix(np.asarray(kappa).tolist())))


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3])
def test_the_moment_is_the_tables_about_any_axis(angle):
    made = law("bending", "table")
    axis = np.array([np.cos(angle), np.sin(angle)])
    for curvature, moment in zip(made.curvature, made.moment, strict=True):
        step = 1e-4
        up, down = (bent(made, (curvature + sign * step) * np.outer(axis, axis)) for sign in (1, -1))
        assert (up - down) / (2 * step) == pytest.approx(moment, rel=1e-5)
        assert bent(made, -curvature * np.outer(axis, axis)) == pytest.approx(
            bent(made, curvature * np.outer(axis, axis))
        )


def test_a_sheet_may_bend_otherwise_downwards_than_upwards():
    made = law("bending", "table", curvature=["-10 1/m", "-2 1/m", "4 1/m"], moment=["-0.3 N", "-0.2 N", "0.1 N"])
    for curvature, moment in zip(made.curvature, made.moment, strict=True):
        up, down = (bent(made, [[curvature + step, 0], [0, 0]]) for step in (1e-4, -1e-4))
        assert (up - down) / 2e-4 == pytest.approx(moment, rel=1e-4)
    assert bent(made, np.zeros((2, 2))) == pytest.approx(0, abs=1e-12)


def test_a_table_of_factors_gives_back_the_speeds_and_is_level_beyond_them():
    made, kelly = law("rate", "table"), KellyRate()
    for speed in (1, 2, 5):
        assert made.factor(speed * MM_PER_MIN) == pytest.approx(kelly.factor(speed * MM_PER_MIN), rel=1e-4)
    assert made.factor(0.0) == made.factor(-1.0) == 0.6632
    assert made.factor(1.0) == 1.8404
    step = in_step(EXPONENTIAL, 0.501, 0.5, time_step=0.25)
    assert number(made.speed(step)) == pytest.approx(number(kelly.speed(step)), rel=1e-14)


def test_creep_by_decades_is_straight_over_the_logarithm_of_time():
    hold = np.logspace(0.3, 2.7, 25)
    pressure = march([law("relaxation", "maxwell")], EXPONENTIAL, rows([0, 1e-3, *hold], [VF0, *[0.55] * 26]))[2:]
    slope, offset = np.polyfit(np.log10(hold), pressure / loading(0.55), 1)
    assert slope == pytest.approx(-0.05, rel=0.05)
    assert np.abs(slope * np.log10(hold) + offset - pressure / loading(0.55)).max() < 2e-3


def test_the_set_grows_with_the_pressure_and_is_given_at_one():
    made = law("unloading", "pressure_set", set_share=0.4, pressure_exponent=0.5, reference_pressure="10 kPa")
    for top in (0.45, 0.52, 0.6):
        share = 1 - 0.6 ** np.sqrt(loading(top) / 1e4)
        stays = VF0 + share * (top - VF0)
        pressure = march([made], EXPONENTIAL, rows(np.arange(4), [VF0, top, stays + 1e-3, stays]))
        assert pressure[2] > 1.0
        assert pressure[3] == pytest.approx(0, abs=1e-6)
        assert pressure[1] == pytest.approx(loading(top), rel=1e-12)


@pytest.mark.parametrize(
    ("laws", "words"),
    [
        ({"shear": {"kind": "table", "angle": [1, 2]}}, "laws.shear.stress = ["),
        ({"shear": {"kind": "table", "angle": [2, 1], "stress": ["1 Pa", "2 Pa"]}}, "expected ascending numbers"),
        ({"shear": {"kind": "table", "angle": [90], "stress": ["1 Pa"]}}, "laws.shear.angle.0 = 90"),
        ({"bending": {"kind": "table", "moment": ["1 N"]}}, "laws.bending.moment = [1.0]: expected 7 entries"),
        (
            {"bending": {"kind": "table", "curvature": ["-1 1/m", "2 1/m"], "moment": ["1 N", "2 N"]}},
            "expected curvatures and moments of the same sign",
        ),
        ({"rate": {"kind": "table", "factors": [1.0, 0.5, 2.0]}}, "laws.rate.factors = [1.0, 0.5, 2.0]: expected asc"),
        ({"unloading": {"kind": "pressure_set", "pressure_exponent": 0}}, "laws.unloading.pressure_exponent = 0"),
    ],
)
def test_tables_that_cannot_be_are_one_line(laws, words):
    with pytest.raises(SceneError) as caught:
        Scene.from_table({"duration": "1 s", "laws": laws})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
