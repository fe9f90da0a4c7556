"""Nodes that share out an error evenly along an axis."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ncf_fenicsx.mesh.equidistribution import RATIO, cheapest, constant_of, error_of, placed, with_lengths

pytestmark = pytest.mark.serial

LENGTH = 30e-3
SQUARES = st.lists(st.one_of(st.just(0.0), st.floats(1e-8, 1e8)), min_size=1, max_size=40)


def smooth(points):
    """Square of a slope that varies slowly enough for no length to be limited."""
    return (1 + 0.5 * np.sin(2 * np.pi * points / LENGTH)) ** 3


@settings(max_examples=30, deadline=None)
@given(squares=SQUARES, count=st.integers(1, 120))
def test_nodes_run_from_end_to_end_and_their_distances_grow_slowly(squares, count):
    lines = np.linspace(0.0, LENGTH, len(squares) + 1)
    positions = placed(lines, np.array(squares), count)
    lengths = np.diff(positions)
    assert len(lengths) == count
    assert (positions[0], positions[-1]) == (0.0, LENGTH)
    assert lengths.min() > 0
    ratios = lengths[1:] / lengths[:-1]
    assert np.maximum(ratios, 1 / ratios).max(initial=1.0) < 1.03 * RATIO


@settings(max_examples=30, deadline=None)
@given(count=st.integers(1, 200), value=st.sampled_from([0.0, 1e-9, 1.0, 1e9]))
def test_an_even_error_gives_even_elements(count, value):
    positions = placed(np.linspace(0.0, LENGTH, 8), np.full(7, value), count)
    assert positions == pytest.approx(np.linspace(0.0, LENGTH, count + 1), abs=1e-6 * LENGTH)


@settings(max_examples=30, deadline=None)
@given(half=SQUARES, count=st.integers(1, 60))
def test_a_symmetric_error_gives_a_symmetric_mesh(half, count):
    squares = np.array([*half, *half[::-1]])
    positions = placed(np.linspace(0.0, LENGTH, len(squares) + 1), squares, count)
    assert positions + positions[::-1] == pytest.approx(np.full(count + 1, LENGTH), abs=1e-3 * LENGTH / count)


def test_each_element_has_the_same_share_in_the_error():
    lines = np.linspace(0.0, LENGTH, 1001)
    squares = smooth((lines[1:] + lines[:-1]) / 2)
    positions = placed(lines, squares, 40)
    middles = (positions[1:] + positions[:-1]) / 2
    shares = np.diff(positions) ** 3 * smooth(middles)
    assert shares == pytest.approx(np.full(40, shares.mean()), rel=0.02)
    assert error_of(lines, squares, positions) == pytest.approx(constant_of(lines, squares) / 40, rel=0.01)


def test_no_other_mesh_of_as_many_elements_has_a_smaller_error():
    lines = np.linspace(0.0, LENGTH, 1001)
    squares = smooth((lines[1:] + lines[:-1]) / 2)
    best = placed(lines, squares, 12)
    rng = np.random.default_rng(1)
    for _ in range(100):
        other = best.copy()
        other[1:-1] += 0.2 * np.diff(best).min() * rng.uniform(-1, 1, 11)
        assert error_of(lines, squares, other) > 0.9999 * error_of(lines, squares, best)


def test_the_error_of_a_mesh_is_that_of_means_of_a_parabola():
    """Of x^2 / 2, whose slope is x: means in elements are off by a known root mean square."""
    lines = np.linspace(0.0, LENGTH, 2001)
    positions = np.array([0.0, 0.2, 0.5, 1.0]) * LENGTH
    low, high = positions[:-1], positions[1:]
    means = (high**3 - low**3) / 6 / (high - low)
    true = (high**5 - low**5) / 20 - means**2 * (high - low)
    found = error_of(lines, ((lines[1:] + lines[:-1]) / 2) ** 2, positions)
    assert found == pytest.approx(np.sqrt(true.sum()), rel=0.03)


@settings(max_examples=30, deadline=None)
@given(x=st.floats(0, 10), y=st.floats(0, 10), error=st.floats(0.05, 1))
def test_the_cheapest_numbers_hold_the_error_and_fewer_do_not(x, y, error):
    many, few = cheapest((x, y), error)
    assert np.hypot(x / many, y / few) <= error * (1 + 1e-9)
    others = [(i, j) for i in range(1, 60) for j in range(1, 60) if np.hypot(x / i, y / j) < 0.999 * error]
    assert all(many * few <= i * j for i, j in others)


def test_elements_are_no_longer_than_wanted():
    points = np.linspace(0.0, LENGTH, 4001)
    places = (points[1:] + points[:-1]) / 2
    wanted = np.where(np.abs(places - 10e-3) < 2e-3, 0.2e-3, 5e-3)
    lines = with_lengths(points, wanted)
    lengths, middles = np.diff(lines), (lines[1:] + lines[:-1]) / 2
    assert (lengths <= 1.02 * np.interp(middles, places, wanted)).all()
    assert (lengths[1:] / lengths[:-1]).min() > 1 / RATIO / 1.03
    assert 25 < len(lengths) < 60
