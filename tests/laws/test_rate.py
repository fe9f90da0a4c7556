"""The rate factor of the compaction pressure."""

import numpy as np
import pytest
from laws_by_number import MM_PER_MIN, VF0, in_step

from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.rate import KellyRate

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("exponent", ["corrected", "as_printed"])
def test_opening_has_the_factor_of_rest_and_the_change_is_smooth(exponent):
    rate = KellyRate(exponent=exponent)
    speeds = np.linspace(-0.02, 0.02, 401) * MM_PER_MIN
    growth = rate.growth(speeds)
    assert np.all(growth[speeds < 0] == rate.growth(0.0))
    assert growth[-1] != rate.growth(0.0)
    slope = np.gradient(growth, speeds) * MM_PER_MIN
    assert np.abs(np.diff(slope)).max() < 1e-5


def test_the_local_closing_speed_is_the_reference_thickness_times_the_strain_rate():
    rate = KellyRate(feed="local", reference_thickness="8 mm")
    stretch = VF0 / np.array([0.5, 0.501])
    strain_rate = (stretch[0] - stretch[1]) / 0.25
    step = in_step(Exponential(), 0.501, 0.5, time_step=0.25, process_speed=1.0)
    assert number(rate.speed(step)) == pytest.approx(8e-3 * strain_rate, rel=1e-12)
    assert KellyRate(feed="process").speed(step) == 1.0
    assert number(rate.speed(in_step(Exponential(), 0.501, 0.5))) < 1e-30  # settling is no closing
