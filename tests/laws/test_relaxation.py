"""Relaxation against exact solutions."""

import numpy as np
import pytest
from laws_by_number import EXPONENTIAL, TWO, VF0, in_step, law, loading, march, rows
from scipy.integrate import quad

from ncf_fenicsx.laws.law import number

pytestmark = pytest.mark.serial
ONE = law("relaxation", "maxwell", branches=[{"share": 0.4, "time": "5 s"}])


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
