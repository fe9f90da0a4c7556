"""Relaxation and unloading against exact solutions and the second law, with no mesh."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws_by_number import VF0, in_step, law, march
from scipy.integrate import quad

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.rate import KellyRate

pytestmark = pytest.mark.serial

EXPONENTIAL = Exponential()
ONE = law("relaxation", "maxwell", branches=[{"share": 0.4, "time": "5 s"}])
TWO = law("relaxation", "maxwell", branches=[{"share": 0.3, "time": "1 s"}, {"share": 0.2, "time": "100 s"}])
SET = law("unloading", "permanent_set", set_share=0.6, exponent=4.0)


def loading(vf):
    return EXPONENTIAL.pressure(vf, VF0)


def rows(times, vf):
    return list(zip(np.asarray(times, dtype=float), np.asarray(vf, dtype=float), strict=True))


# relaxation


@pytest.mark.parametrize("steps", [1, 3, 20])
def test_a_hold_after_a_jump_decays_as_the_exact_solution_at_any_step(steps):
    hold = np.linspace(0, 30, steps + 1)
    history = rows([0.0, *hold], [VF0, *np.full(steps + 1, 0.55)])
    pressure = march([TWO], EXPONENTIAL, history)[1:]
    exact = loading(0.55) * (1 + 0.3 * np.exp(-hold / 1.0) + 0.2 * np.exp(-hold / 100.0))
    assert pressure == pytest.approx(exact, rel=1e-12)


def test_a_ramp_of_pressure_is_exact_at_any_step():
    """Where p grows at a constant rate r, a branch carries share r time (1 - exp(-t / time))."""
    linear = law("compaction", "power", exponent=1.0, scale="1 MPa")
    times = np.array([0.0, 0.5, 2.0, 10.0, 11.0])
    history = rows(times, VF0 + 0.01 * times)
    exact = 1e4 * times + 0.4 * 1e4 * 5.0 * (1 - np.exp(-times / 5.0))
    assert march([ONE], linear, history) == pytest.approx(exact, rel=1e-10)


def test_the_error_in_a_ramp_of_thickness_is_of_order_two():
    """Against the hereditary integral of the loading curve."""
    end, rate = 6.0, 0.02

    def vf(t):
        return VF0 / (1 - rate * t)

    def pressure_rate(t, step=1e-6):
        return (loading(vf(t + step)) - loading(vf(t - step))) / (2 * step)

    overstress, _ = quad(lambda t: np.exp(-(end - t) / 5.0) * pressure_rate(t), 0, end, epsabs=1e-9)
    exact = loading(vf(end)) + 0.4 * overstress
    errors = []
    for steps in (4, 8, 16, 32):
        times = np.linspace(0, end, steps + 1)
        errors.append(abs(march([ONE], EXPONENTIAL, rows(times, vf(times)))[-1] - exact))
    order = np.polyfit(np.log([4, 8, 16, 32]), np.log(errors), 1)[0]
    assert -2.1 < order < -1.9


def test_a_stack_at_rest_has_relaxed():
    """Settling takes for ever: nothing is left to relax when the first step begins."""
    step = in_step(EXPONENTIAL, 0.5, time_step=1e30)
    assert number(ONE.pressure(step, {"relaxing_pressure_1": 0.0})) < 1e-20
    assert number(ONE.updated_states(step, {"relaxing_pressure_1": 70.0})["relaxing_pressure_1"]) < 1e-20


# unloading


def test_unloading_goes_to_the_permanent_set_and_reloading_rejoins_the_loading_curve():
    top = 0.58
    stays = VF0 + 0.6 * (top - VF0)
    down = np.linspace(top, stays, 9)
    vf = [VF0, 0.5, top, *down, *down[::-1], 0.6]
    pressure = march([SET], EXPONENTIAL, rows(np.arange(len(vf)), vf))
    assert pressure[1:3] == pytest.approx([loading(0.5), loading(top)], rel=1e-12)
    u = (down - stays) / (top - stays)
    expected = loading(down - 0.6 * (top - VF0) * (1 - u**4))
    assert pressure[3:12] == pytest.approx(expected, rel=1e-10, abs=1e-8)
    assert pressure[11] == pytest.approx(0.0, abs=1e-8)
    assert pressure[12:21] == pytest.approx(pressure[3:12][::-1], abs=1e-8)
    assert pressure[-1] == pytest.approx(loading(0.6), rel=1e-12)


def test_unloading_lies_below_loading_and_a_larger_exponent_drops_steeper():
    vf = np.linspace(0.57, 0.52, 6)
    curves = []
    for exponent in (1.5, 4.0):
        made = law("unloading", "permanent_set", set_share=0.3, exponent=exponent)
        curves.append(march([made], EXPONENTIAL, rows(np.arange(8), [VF0, 0.58, *vf]))[2:])
    assert np.all(curves[0] < loading(vf))
    assert np.all(curves[1] < curves[0])


def test_without_a_set_unloading_is_elastic():
    made = law("unloading", "permanent_set", set_share=0.0)
    vf = [VF0, 0.58, 0.5, 0.42, 0.39]
    assert march([made], EXPONENTIAL, rows(range(5), vf))[1:] == pytest.approx(loading(np.array(vf[1:])), rel=1e-12)


def test_below_the_set_the_fabric_is_stretched_from_there():
    stays = VF0 + 0.6 * (0.58 - VF0)
    pressure = march([SET], EXPONENTIAL, rows(range(3), [VF0, 0.58, stays - 0.01]))
    assert pressure[-1] == pytest.approx(loading(VF0 - 0.01), rel=1e-12)


def work_of(history, pressure):
    """Work in J/m3 done on the fabric up to each time: integral of -p d lambda_3 by the trapezoidal rule."""
    stretch = VF0 / np.array([vf for _, vf in history])
    return np.concatenate([[0.0], np.cumsum(-(pressure[1:] + pressure[:-1]) / 2 * np.diff(stretch))])


def refined(times, vf, parts=12):
    fine = np.linspace(0, len(times) - 1, (len(times) - 1) * parts + 1)
    return rows(np.interp(fine, np.arange(len(times)), times), np.interp(fine, np.arange(len(times)), vf))


LOCAL = KellyRate(feed="local")
CASES = {
    "rate factor": ([], LOCAL),
    "unloading": ([SET], None),
    "relaxation": ([TWO], None),
    "both with the rate factor": ([SET, TWO], LOCAL),
}


@pytest.mark.parametrize("case", CASES)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.floats(0.05, 20), st.floats(VF0 - 0.03, 0.62)), min_size=2, max_size=5),
    st.floats(0.05, 20),
)
def test_a_cycle_never_creates_energy(case, points, last):
    """Random histories from Vf0 back to Vf0, also pulled apart: the work done on the fabric is never negative."""
    laws, rate = CASES[case]
    times = np.cumsum([0.0, *(time for time, _ in points), last])
    history = refined(times, np.array([VF0, *(vf for _, vf in points), VF0]))
    work = work_of(history, march(laws, EXPONENTIAL, history, rate))
    assert work[-1] > -2e-3 * np.abs(work).max()  # the rule's own error, where the cycle is elastic


def test_the_work_test_sees_a_law_that_creates_energy():
    """The same measure on a law that unloads above its loading curve."""
    history = refined([0.0, 1.0, 2.0], [VF0, 0.6, VF0], parts=40)
    up = np.array([vf1 > vf0 for (_, vf0), (_, vf1) in pairwise(history)])
    vf = np.array([vf for _, vf in history])
    wrong = loading(vf) * np.concatenate([[1.0], np.where(up, 1.0, 1.3)])
    assert work_of(history, wrong)[-1] < -0.1 * work_of(history, wrong).max()


def test_hysteresis_dissipates_what_lies_between_the_curves():
    parts = 400
    history = refined([0.0, 1.0, 2.0], [VF0, 0.58, VF0], parts=parts)
    pressure = march([SET], EXPONENTIAL, history)
    stored = EXPONENTIAL.energy(0.58, VF0)
    gain = 0.58 - VF0

    def unloading(x):
        u = np.clip((x - VF0 - 0.6 * gain) / (0.4 * gain), 0, 1)
        return loading(x - 0.6 * gain * (1 - u**4))

    given_back, _ = quad(lambda x: unloading(x) * VF0 / x**2, VF0, 0.58, points=[VF0 + 0.6 * gain])
    assert work_of(history, pressure)[-1] == pytest.approx(stored - given_back, rel=1e-4)


@pytest.mark.parametrize(
    ("laws", "words"),
    [
        ({"unloading": {}, "compaction": {"toe": "raw"}}, "expected a compaction law that is free of stress at Vf0"),
        ({"unloading": {"set_share": 1.0}}, "laws.unloading.set_share = 1.0: expected less than 1"),
        ({"unloading": {"exponent": 0.5}}, "laws.unloading.exponent = 0.5: expected greater than or equal to 1"),
        ({"relaxation": {"branches": []}}, "laws.relaxation.branches = []: expected at least one entry"),
        ({"relaxation": {"branches": [{"time": "0 s"}]}}, "branches.0.time = '0 s': expected a positive time"),
        ({"relaxation": {"branches": [{"share": -1}]}}, "branches.0.share = -1: expected greater than 0"),
    ],
)
def test_bad_parameters_are_one_line(laws, words):
    with pytest.raises(SceneError) as caught:
        Scene.from_table({"duration": "1 s", "laws": laws})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
