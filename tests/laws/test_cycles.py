"""Laws with a memory obey the second law; their bad parameters are named."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws_by_number import EXPONENTIAL, SET, TWO, VF0, law, loading, march, rows
from scipy.integrate import quad

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.laws.rate import KellyRate

pytestmark = pytest.mark.serial


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
    "set by pressure": ([law("unloading", "pressure_set", set_share=0.6, exponent=3.0)], None),
    "rate table": ([], law("rate", "table")),
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
