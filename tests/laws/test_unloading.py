"""Unloading to a permanent set and reloading."""

import numpy as np
import pytest
from laws_by_number import EXPONENTIAL, SET, VF0, law, loading, march, rows

pytestmark = pytest.mark.serial


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
