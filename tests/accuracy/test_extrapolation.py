"""Error bars of made-up sequences whose limits are known."""

import math
from itertools import pairwise

import numpy as np
import pytest

from ncf_fenicsx.accuracy.extrapolation import Basis, estimate, of_differences

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("levels", [3, 4, 6])
def test_an_even_sequence_has_its_order_its_limit_and_a_bar_that_holds(order, levels):
    found = estimate([5.0 + 0.3 * 2.0 ** (-order * level) for level in range(levels)])
    assert found.basis is Basis.ORDER
    assert found.order == pytest.approx(order)
    assert found.limit == pytest.approx(5.0)
    true = abs(found.value - 5.0)
    assert found.bar > 1.2 * true
    if levels > 3 or order <= 1:
        assert found.bar == pytest.approx(1.25 * true)
    assert found.relative == pytest.approx(found.bar / found.value)


def test_a_high_order_that_is_seen_once_makes_no_bar_smaller_than_a_first_one():
    found = estimate([1.0, 1.8, 2.0])
    assert found.order == pytest.approx(2)
    assert found.bar == pytest.approx(1.25 * 0.8 / 2)
    found = estimate([1.0, 1.8, 2.0, 2.02])
    assert found.bar == pytest.approx(1.25 * 0.8 / 4)


@pytest.mark.parametrize(
    "values",
    [
        [1.0, 2.0, 1.5, 1.75],  # to and fro
        [1.0, 1.001, 1.1, 1.12],  # an early chance
        [1.0, 1.1, 1.19, 1.27],  # hardly shrinking
        [1.0, 1.1, 1.3],  # growing
        [1.0, 2.0, 2.01],  # faster than any method here
    ],
)
def test_where_no_order_settles_there_is_a_bar_and_no_limit(values):
    found = estimate(values)
    assert found.basis is Basis.DIFFERENCES
    assert math.isnan(found.order)
    assert math.isnan(found.limit)
    assert found.bar >= 1.25 * abs(values[-1] - values[-2])


def test_a_jump_that_two_levels_hide_is_remembered():
    found = estimate([1.0, 1.4, 1.39, 1.392])
    assert found.bar == pytest.approx(1.25 * 0.4 / 4)


def test_differences_that_grow_are_not_believed():
    assert estimate([1.0, 1.1, 1.3]).bar == pytest.approx(3 * 0.2)


def test_one_value_has_no_bar_and_two_have_one_of_first_order():
    assert estimate([3.0]).bar == math.inf
    found = estimate([3.0, 3.1])
    assert found.basis is Basis.FIRST_ORDER
    assert found.bar == pytest.approx(0.3)


def test_answers_of_different_branches_have_their_spread():
    values = [1.0, 1.5, 1.75, 1.875]
    found = estimate(values, branches=True)
    assert found.basis is Basis.SPREAD
    assert found.bar == pytest.approx(1.25 * 0.875)
    assert found.bar > estimate(values).bar


def test_what_is_nothing_in_all_levels_is_known():
    assert estimate([0.0, 0.0, 0.0]).relative == 0
    assert estimate([0.0, 0.0, 0.0, 1e-9]).relative > 1


def test_a_field_of_first_order_is_inside_its_bar():
    """Norms of differences of nested cell means: those of a straight line, whose error is known."""
    errors = [np.sqrt(1 / 12) / 2**level for level in range(5)]
    differences = [math.sqrt(coarse**2 - fine**2) for coarse, fine in pairwise(errors)]
    found = of_differences(1.0, differences)
    assert found.order == pytest.approx(1.0)
    assert errors[-1] < found.bar < 3 * errors[-1]


@pytest.mark.parametrize("noise", [0.1, 0.3])
@pytest.mark.parametrize("order", [1.0, 2.0])
def test_nine_in_ten_noisy_sequences_are_inside_their_bars(order, noise):
    """Noise that is a share of the error, and shrinks with it."""
    chance = np.random.default_rng(3)
    held, over = [], []
    for _ in range(500):
        sizes = 0.1 * 2.0 ** (-order * np.arange(4))
        found = estimate(list(1.0 - sizes * (1 + chance.uniform(-noise, noise, 4))))
        held.append(abs(found.value - 1.0) <= found.bar)
        over.append(found.bar / abs(found.value - 1.0))
    assert np.mean(held) > 0.9
    assert order == 2 or np.median(over) < 3
