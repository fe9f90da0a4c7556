"""Crests measured on surfaces whose answers are known: heights, lift-off, places, also where the surface overhangs."""

import math

import numpy as np
import pytest
from flat_grids import LENGTH, WIDTH, grid
from scipy.optimize import brentq
from scipy.signal import find_peaks, peak_prominences

from ncf_fenicsx.output import wrinkles as waves
from ncf_fenicsx.output.crests import Crest, _highest, highest_crest

pytestmark = pytest.mark.serial
FLOOR = 1e-6


def strip(n=200, length=LENGTH):
    return grid(np.linspace(0, length, n + 1), np.linspace(0, WIDTH, 3))[0]


def scattered(n):
    """Nodes of a square grid, moved at random by up to a quarter of the spacing off the outline."""
    positions = grid(np.linspace(0, LENGTH, n + 1), np.linspace(0, WIDTH, n // 2 + 1))[0]
    moved = positions + 0.25 * LENGTH / n * np.random.default_rng(n).uniform(-1, 1, positions.shape)
    inside = (positions > 1e-9) & (positions < np.array([LENGTH, WIDTH]) - 1e-9)
    return np.where(inside, moved, positions)


def crest_of(positions, lift, moved=0.0, model=None):
    if model is None:
        model = np.array([positions.min(axis=0), positions.max(axis=0)])
    return highest_crest(positions, positions + moved, lift, model, FLOOR)


def ruck(x, centre, length, height):
    """Heavy sheet pushed up on a plane, small slopes: lift, slope and curvature are 0 at both ends, tan(k L/2) = k L/2.

    B w'''' + P w'' + q = 0 has w = q / P (a^2 - x^2) / 2 + c (cos k x - cos k a) with a = L / 2.
    """
    half = length / 2
    k = brentq(lambda k: math.tan(k) - k, 4.4, 4.6) / half
    c = 1 / (k**2 * math.cos(k * half))

    def shape(s):
        return (half**2 - s**2) / 2 + c * (np.cos(k * half) - np.cos(k * s))

    s = np.clip(x - centre, -half, half)
    return height * shape(s) / shape(0.0)


@pytest.mark.parametrize("nodes", [100, 200, 400])
@pytest.mark.parametrize("centre", [50e-3, 50.3e-3])
def test_a_ruck_has_its_height_its_length_and_its_place(nodes, centre):
    """The sheet leaves the plane without slope and curvature, so that an edge by a threshold would be far off."""
    x = strip(nodes)
    crest = crest_of(x, ruck(x[:, 0], centre, 40e-3, 2e-3))
    assert crest.height == pytest.approx(2e-3, rel=2e-3)
    assert crest.lift == pytest.approx(2e-3, rel=2e-3)
    assert crest.length == pytest.approx(40e-3, rel=0.01)
    assert crest.x == pytest.approx(centre, abs=0.02e-3)
    assert crest.count == 1


def test_layers_that_spring_back_below_do_not_make_a_ruck_longer():
    """On top of other layers the face beside the ruck is not flat: a per mille of its height, here and there."""
    x = strip(400)
    rough = 2e-6 * np.random.default_rng(4).uniform(-1, 1, len(x))
    crest = crest_of(x, ruck(x[:, 0], 50e-3, 40e-3, 2e-3) + rough)
    assert crest.height == pytest.approx(2e-3, rel=5e-3)
    assert crest.length == pytest.approx(40e-3, rel=0.03)
    assert crest.count == 1


def test_a_trough_under_a_tool_and_a_curled_edge_are_no_part_of_a_crest():
    """The crest stands over the higher of its troughs; an edge that curls up is no crest."""
    x = strip()[:, 0]
    pressed = np.where(abs(x - 20e-3) < 5e-3, -0.5e-3, 0.0)
    curled = 3e-3 * np.maximum(x / LENGTH - 0.9, 0.0) * 10
    assert crest_of(strip(), pressed) == Crest()
    assert crest_of(strip(), curled) == Crest()
    crest = crest_of(strip(), pressed + curled + ruck(x, 50e-3, 40e-3, 2e-3))
    assert crest.height == pytest.approx(2e-3, rel=2e-3)
    assert crest.length == pytest.approx(40e-3, rel=0.01)


def test_waves_are_counted_and_those_of_a_tenth_are_not_noise():
    x = strip()
    sine = 1e-3 * np.sin(2 * np.pi * x[:, 0] / 20e-3)
    crest = crest_of(x, sine + 0.02e-3 * np.sin(2 * np.pi * x[:, 0] / 3e-3) + 0.01 * x[:, 0])
    assert crest.count == 5
    assert crest.height == pytest.approx(2e-3, rel=0.05)
    assert crest.length == pytest.approx(20e-3, rel=0.1)


def test_a_crest_of_two_tops_is_one():
    """A dip of 30 % of its height does not split it; one of 70 % does, and each stands over that dip."""
    x = strip()
    tops = [ruck(x[:, 0], centre, 30e-3, 1e-3) for centre in (43e-3, 57e-3)]
    for dip, height, length in ((0.3, 1.0, 44e-3), (0.7, 0.7, 15.5e-3)):
        bottom = sum(tops)[np.argmin(abs(x[:, 0] - 50e-3))]
        between = np.where(abs(x[:, 0] - 50e-3) < 7e-3, np.cos(np.pi * (x[:, 0] - 50e-3) / 14e-3) ** 2, 0.0)
        lift = sum(tops) - between * (bottom - (1 - dip) * sum(tops).max())
        crest = crest_of(x, lift)
        assert crest.count == 2
        assert crest.height == pytest.approx(height * sum(tops).max(), rel=0.01)
        assert crest.length == pytest.approx(length, rel=0.05)


def test_a_face_that_overhangs_keeps_its_measures():
    """A fold of arcs of 120 degrees: lines followed along their nodes need no graph over x."""
    radius, angle = 10e-3, math.radians(120)
    s = np.linspace(0, 4 * angle * radius, 481)
    turned = np.interp(s, np.array([0, 1, 3, 4]) * angle * radius, np.array([0, 1, -1, 0]) * angle)
    step = np.diff(s)[0]
    middle = (turned[1:] + turned[:-1]) / 2
    chord = step * np.sinc(np.diff(turned) / 2 / np.pi)  # of an arc
    x = np.concatenate([[0], np.cumsum(chord * np.cos(middle))])
    z = np.concatenate([[0], np.cumsum(chord * np.sin(middle))])
    height = 2 * radius * (1 - math.cos(angle))
    flat, plan = (np.column_stack([line, np.zeros_like(line)]) for line in (s, x))
    crest = highest_crest(flat, plan, z, np.array([[0, 0], [s[-1], 0]]), FLOOR)
    assert crest.height == pytest.approx(height, rel=1e-6)
    assert crest.x == pytest.approx(2 * radius * math.sin(angle), rel=1e-3)
    found = waves.wrinkles(flat, np.column_stack([plan - flat, z]))
    assert found.misalignment == pytest.approx(angle, abs=step / radius)
    assert found.curvature == pytest.approx(1 / radius, rel=1e-3)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_hill_is_found_where_it_is_along_both_axes_and_without_a_grid(axis):
    positions = scattered(160) if axis == 0 else scattered(160)[:, ::-1]
    centre, width = np.array([42e-3, 27e-3] if axis == 0 else [27e-3, 42e-3]), 20e-3
    distance = np.linalg.norm(positions - centre, axis=1) / width
    lift = np.where(distance < 1, 1e-3 * np.cos(np.pi * distance / 2) ** 4, 0.0)
    crest = crest_of(positions, lift, moved=np.array([1e-3, -2e-3]))
    assert crest.height == pytest.approx(1e-3, rel=0.01)
    assert np.array([crest.x, crest.y]) == pytest.approx(centre + np.array([1e-3, -2e-3]), abs=0.3e-3)
    assert 25e-3 < crest.length <= 2 * width


def test_of_equal_crests_that_in_the_model_counts():
    """A face and its mirror image have two; the model ends at x = 50 mm, or begins there."""
    x = strip()
    lift = ruck(x[:, 0], 25e-3, 30e-3, 1e-3) + ruck(x[:, 0], 75e-3, 30e-3, 1e-3)
    for low, high, place in ((0.0, 0.05, 25e-3), (0.05, 0.1, 75e-3)):
        crest = crest_of(x, lift, model=np.array([[low, 0.0], [high, WIDTH]]))
        assert crest.x == pytest.approx(place, abs=0.1e-3)
        assert crest.count == 2


def test_flat_tilted_and_minute_faces_have_no_crest():
    positions = strip()
    noise = 0.4 * FLOOR * np.random.default_rng(1).uniform(-1, 1, len(positions))
    for lift in (np.zeros(len(positions)), 0.1 * positions[:, 0], noise):
        assert crest_of(positions, lift) == Crest()


def test_no_crest_is_higher_than_the_bound_that_lines_are_left_out_by():
    numbers = np.random.default_rng(0)
    for _ in range(200):
        lift = numbers.normal(size=numbers.integers(3, 30)).cumsum()
        nodes = find_peaks(lift)[0]
        assert peak_prominences(lift, nodes)[0].max(initial=0.0) <= _highest(lift) + 1e-12
    assert _highest(np.array([0.0, 1.0, 3.0, 4.0])) == 0.0  # a slope
    assert _highest(np.array([4.0, 1.0, 3.0])) == 0.0  # a trough
