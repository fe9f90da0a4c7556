"""Errors at each step of a history, from those of coarser levels at other times."""

from types import SimpleNamespace

import numpy as np
import pytest

from ncf_fenicsx.accuracy.bands import errors

pytestmark = pytest.mark.serial


def level(number, order=1.0):
    """A history with other steps at each level, whose error grows with time and shrinks with an order."""
    time = np.linspace(0.0, 4.0, 5 + 4 * number)
    return SimpleNamespace(history={"time": time, "tool_force": (3 + 0.5 ** (order * number)) * time})


@pytest.mark.parametrize(("count", "factor"), [(2, 3.0), (3, 1.25), (4, 1.25)])
def test_the_band_follows_the_error_of_each_step(count, factor):
    """Of first order it is the true error by the factor of safety."""
    found = errors([level(number) for number in range(count)], "tool_force")
    true = 0.5 ** (count - 1) * level(count - 1).history["time"]
    assert found == pytest.approx(factor * true)


def test_of_levels_on_different_branches_it_is_their_spread():
    found = errors([level(number) for number in range(3)], "tool_force", branches=True)
    assert found == pytest.approx(1.25 * 0.75 * level(2).history["time"])
    of_two = errors([level(0), level(1)], "tool_force", branches=True)
    assert of_two == pytest.approx(3.0 * 0.5 * level(1).history["time"])  # two may agree by chance
