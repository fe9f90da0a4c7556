"""Wrinkles, voids and the extent of contact against surfaces whose answers are known."""

import math

import numpy as np
import pytest

from ncf_fenicsx.mesh import hexahedra
from ncf_fenicsx.output.voids import contact_extent, voids
from ncf_fenicsx.output.wrinkles import Wrinkles, crossing_wavelength, spectral_wavelength, wrinkles

pytestmark = pytest.mark.serial

AMPLITUDE, WAVELENGTH = 0.5e-3, 20e-3
LENGTH, WIDTH = 0.1, 0.05
ANGLE = math.radians(8.927)
CURVATURE = AMPLITUDE * (2 * math.pi / WAVELENGTH) ** 2


def grid(x, y):
    """Places and quads of a grid, with each node's share of the area."""
    X, Y = np.meshgrid(x, y)
    node = np.arange(X.size).reshape(X.shape)
    quads = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]], axis=-1).reshape(-1, 4)
    area = np.outer(np.gradient(y) * share(y), np.gradient(x) * share(x))
    return np.stack([X.ravel(), Y.ravel()], axis=1), quads, area.ravel()


def share(coordinate):
    return np.where((coordinate == coordinate[0]) | (coordinate == coordinate[-1]), 0.5, 1.0)


def uniform(n):
    return grid(np.linspace(0, LENGTH, n + 1), np.linspace(0, WIDTH, n // 2 + 1))[0]


def graded(n):
    y = hexahedra.graded(n // 2, WIDTH, 0.0, 0.5)
    return grid(hexahedra.graded(n, LENGTH, 0.04, 0.5), y)[0]


def scattered(n):
    """Nodes of a uniform grid, those off the outline moved at random by up to a quarter of the spacing."""
    places = uniform(n)
    moved = places + 0.25 * LENGTH / n * np.random.default_rng(n).uniform(-1, 1, places.shape)
    inside = (places > 1e-9) & (places < np.array([LENGTH, WIDTH]) - 1e-9)
    return np.where(inside, moved, places)


def sine(position):
    return AMPLITUDE * np.sin(2 * np.pi * position / WAVELENGTH + 0.3)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("nodes", [uniform, graded, scattered])
def test_a_sine_has_its_amplitude_wavelength_angle_and_curvature(nodes, axis):
    places = nodes(160)
    places = places if axis == 0 else places[:, ::-1]
    order = np.random.default_rng(0).permutation(len(places))
    measured = wrinkles(places[order], sine(places[order, axis]))
    assert measured.amplitude == pytest.approx(AMPLITUDE, rel=1e-2)
    assert measured.wavelength == pytest.approx(WAVELENGTH, rel=1e-2)
    assert measured.misalignment == pytest.approx(ANGLE, rel=1e-2)
    assert measured.curvature == pytest.approx(CURVATURE, rel=1e-2)


@pytest.mark.parametrize(("nodes", "order"), [(uniform, 1.9), (graded, 1.7), (scattered, 1.0)])
def test_angle_and_curvature_converge_under_refinement(nodes, order):
    spacings, errors = [], []
    for n in (20, 40, 80, 160):
        places = nodes(n)
        # the steepest place lies differently between the nodes of every grid: the worst of some phases
        found = [wrinkles(places, sine(places[:, 0] + shift)) for shift in np.linspace(0, WAVELENGTH / 2, 12)]
        angles = max(abs(w.misalignment / math.atan(2 * math.pi * AMPLITUDE / WAVELENGTH) - 1) for w in found)
        spacings.append(LENGTH / n)
        errors.append([angles, max(abs(w.curvature / CURVATURE - 1) for w in found)])
    orders = np.polyfit(np.log(spacings), np.log(errors), 1)[0]
    assert np.all(orders > order), (orders, errors)


@pytest.mark.parametrize("points", [np.linspace(0, LENGTH, 101), hexahedra.graded(100, LENGTH, 0.0, 0.6)])
def test_both_wavelengths_agree_with_and_without_noise(points):
    noise = 0.01 * AMPLITUDE * np.random.default_rng(3).uniform(-1, 1, len(points))
    for w in (sine(points), sine(points) + noise, sine(points) + 0.3e-3):
        crossing, spectral = crossing_wavelength(points, w), spectral_wavelength(points, w)
        assert crossing == pytest.approx(WAVELENGTH, rel=0.01)
        assert spectral == pytest.approx(crossing, rel=0.015)


def test_noise_hardly_changes_the_wavelength_of_fine_and_scattered_surfaces():
    for places in (uniform(200), graded(200), scattered(100)):
        noise = 0.01 * AMPLITUDE * np.random.default_rng(5).uniform(-1, 1, len(places))
        assert wrinkles(places, sine(places[:, 0]) + noise).wavelength == pytest.approx(WAVELENGTH, rel=0.03)


def test_the_line_with_the_largest_amplitude_gives_the_wavelength():
    places = uniform(200)
    fading = sine(places[:, 0]) * (1 - places[:, 1] / WIDTH)
    across = 0.1e-3 * np.sin(2 * np.pi * places[:, 1] / 10e-3)
    assert wrinkles(places, fading + across).wavelength == pytest.approx(WAVELENGTH, rel=0.01)


def test_flat_and_tilted_surfaces_have_no_wave():
    for places in (uniform(20), scattered(20)):
        assert wrinkles(places, np.full(len(places), -1e-3)) == Wrinkles(0.0, 0.0, 0.0, 0.0)
        rough = wrinkles(places, 1e-12 * np.random.default_rng(2).uniform(-1, 1, len(places)))
        assert (rough.wavelength, rough.misalignment, rough.curvature) == (0.0, 0.0, 0.0)
        tilted = wrinkles(places, 0.02 * places[:, 0])
        assert tilted.misalignment == pytest.approx(math.atan(0.02))
        assert tilted.curvature == pytest.approx(0.0, abs=1e-9)
        assert tilted.wavelength == 0.0
    line = np.linspace(0, LENGTH, 50)
    assert spectral_wavelength(line, 0.02 * line) == 0.0


def test_a_strip_of_one_line_and_a_round_surface_are_measured_too():
    strip = np.stack([np.linspace(0, LENGTH, 201), np.zeros(201)], axis=1)
    assert wrinkles(strip, sine(strip[:, 0])).wavelength == pytest.approx(WAVELENGTH, rel=1e-3)
    places = scattered(120)
    disc = places[np.hypot(places[:, 0] - 0.05, places[:, 1] - 0.025) < 0.025]
    measured = wrinkles(disc, sine(disc[:, 0]))
    assert measured.wavelength == pytest.approx(WAVELENGTH, rel=0.01)
    assert measured.misalignment == pytest.approx(ANGLE, rel=0.05)
    assert measured.curvature == pytest.approx(CURVATURE, rel=0.1)


def cap(places, centre, radius, height):
    """A paraboloid gap, below zero outside the radius; its volume is pi radius^2 height / 2."""
    return height * (1 - ((places - centre) ** 2).sum(axis=1) / radius**2)


def test_a_paraboloid_void_has_its_volume_and_length():
    radius, height, tolerance = 0.02, 1e-3, 0.1e-3
    errors = []
    for n in (25, 50, 100):
        places, quads, area = grid(np.linspace(0, 0.06, n), np.linspace(0, 0.05, n))
        measured = voids(places, quads, cap(places, (0.03, 0.025), radius, height), area, tolerance)
        exact = math.pi * radius**2 * height / 2, 2 * radius * math.sqrt(1 - tolerance / height), height
        found = measured.volume, measured.longest, measured.widest_opening
        errors.append([abs(a / b - 1) for a, b in zip(found, exact, strict=True)])
    assert np.all(np.array(errors[-1]) < 1e-3), errors
    assert voids(places, quads[:, [1, 0, 3, 2]], cap(places, (0.03, 0.025), radius, height), area, 1e-4) == measured


def test_of_two_voids_the_longer_one_counts_and_their_volumes_add():
    places, quads, area = grid(np.linspace(0, 0.1, 201), np.linspace(0, 0.05, 101))
    gap = np.maximum(cap(places, (0.02, 0.025), 0.01, 1e-3), cap(places, (0.07, 0.025), 0.02, 0.5e-3))
    measured = voids(places, quads, gap, area, 1e-6)
    assert measured.longest == pytest.approx(0.04, rel=5e-3)
    assert measured.volume == pytest.approx(math.pi / 2 * (0.01**2 * 1e-3 + 0.02**2 * 0.5e-3), rel=2e-3)
    assert measured.widest_opening == pytest.approx(1e-3)


def test_voids_that_touch_at_a_corner_of_a_quad_are_two():
    places, quads, area = grid(np.arange(5.0), np.arange(5.0))
    gap = np.full(25, -1.0)
    gap[[6, 12]] = 1.0  # at (1, 1) and (2, 2)
    assert voids(places, quads, gap, area, 0.0).longest == pytest.approx(1.0)
    gap[7] = 1.0
    assert voids(places, quads, gap, area, 0.0).longest == pytest.approx(2.0)


def test_a_closed_surface_has_no_void_and_an_open_one_no_contact():
    places, quads, area = grid(np.linspace(0, 0.1, 5), np.linspace(0, 0.05, 4))
    shut = voids(places, quads, np.full(20, -1e-6), area, 1e-6)
    assert (shut.volume, shut.longest, shut.widest_opening) == (0.0, 0.0, 0.0)
    assert contact_extent(places, quads, np.full(20, 1e-6)) == (0.0, 0.0)
    assert contact_extent(places, quads, np.zeros(20)) == pytest.approx((0.1, 0.05))
    assert voids(places, quads, np.full(20, 1e-3), area, 1e-6).longest == pytest.approx(0.1)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_cylinder_touches_over_the_width_of_its_parabola(flipped):
    radius, depth = 0.05, 0.2e-3
    width, errors, spacings = 2 * math.sqrt(2 * radius * depth), [], []
    for n in (20, 40, 80, 160):
        x = np.linspace(-0.02, 0.02, n + 1)
        places, quads, _ = grid(x, np.linspace(0, 0.03, 7))
        quads = quads[:, [1, 0, 3, 2]] if flipped else quads
        along_x, along_y = contact_extent(places, quads, places[:, 0] ** 2 / (2 * radius) - depth)
        assert along_y == pytest.approx(0.03)
        errors.append(abs(along_x - width))
        spacings.append(x[1] - x[0])
    assert errors[-1] < 1e-3 * width
    # chord of a parabola: the border is off by at most h^2/8 w'' / slope
    assert all(error <= 2 * h**2 / (4 * width) for error, h in zip(errors, spacings, strict=True))


def test_a_zone_of_one_node_reaches_to_the_crossings_of_its_edges():
    places, quads, _ = grid(np.arange(3.0), np.arange(3.0))
    gap = np.full(9, 3.0)
    gap[4] = -1.0
    assert contact_extent(places, quads, gap) == pytest.approx((0.5, 0.5))
