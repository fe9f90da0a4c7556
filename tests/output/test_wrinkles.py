"""Wrinkles measured on surfaces whose answers are known."""

import math

import numpy as np
import pytest
from flat_grids import LENGTH, WIDTH, grid

from ncf_fenicsx.mesh import hexahedra
from ncf_fenicsx.output import wrinkles as waves
from ncf_fenicsx.output.wrinkles import Wrinkles, crossing_wavelength, spectral_wavelength

pytestmark = pytest.mark.serial
AMPLITUDE, WAVELENGTH = 0.5e-3, 20e-3
ANGLE = math.radians(8.927)
CURVATURE = AMPLITUDE * (2 * math.pi / WAVELENGTH) ** 2


def wrinkles(positions, deflection):
    """Waves of a surface whose nodes move up and down only."""
    return waves.wrinkles(positions, np.column_stack([np.zeros_like(positions), deflection]))


def uniform(n):
    return grid(np.linspace(0, LENGTH, n + 1), np.linspace(0, WIDTH, n // 2 + 1))[0]


def graded(n):
    y = hexahedra.graded(n // 2, WIDTH, 0.0, 0.5)
    return grid(hexahedra.graded(n, LENGTH, 0.04, 0.5), y)[0]


def scattered(n):
    """Nodes of a uniform grid, those off the outline moved at random by up to a quarter of the spacing."""
    positions = uniform(n)
    moved = positions + 0.25 * LENGTH / n * np.random.default_rng(n).uniform(-1, 1, positions.shape)
    inside = (positions > 1e-9) & (positions < np.array([LENGTH, WIDTH]) - 1e-9)
    return np.where(inside, moved, positions)


def sine(position):
    return AMPLITUDE * np.sin(2 * np.pi * position / WAVELENGTH + 0.3)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("nodes", [uniform, graded, scattered])
def test_a_sine_has_its_amplitude_wavelength_angle_and_curvature(nodes, axis):
    positions = nodes(160)
    positions = positions if axis == 0 else positions[:, ::-1]
    order = np.random.default_rng(0).permutation(len(positions))
    measured = wrinkles(positions[order], sine(positions[order, axis]))
    assert measured.amplitude == pytest.approx(AMPLITUDE, rel=1e-2)
    assert measured.wavelength == pytest.approx(WAVELENGTH, rel=1e-2)
    assert measured.misalignment == pytest.approx(ANGLE, rel=1e-2)
    assert measured.curvature == pytest.approx(CURVATURE, rel=1e-2)


@pytest.mark.parametrize(("nodes", "order"), [(uniform, 1.85), (graded, 1.7), (scattered, 1.0)])
def test_angle_and_curvature_converge_under_refinement(nodes, order):
    spacings, errors = [], []
    for n in (20, 40, 80, 160):
        positions = nodes(n)
        # the steepest place lies differently between the nodes of every grid: the worst of some phases
        found = [wrinkles(positions, sine(positions[:, 0] + shift)) for shift in np.linspace(0, WAVELENGTH / 2, 12)]
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
    for positions in (uniform(200), graded(200), scattered(100)):
        noise = 0.01 * AMPLITUDE * np.random.default_rng(5).uniform(-1, 1, len(positions))
        assert wrinkles(positions, sine(positions[:, 0]) + noise).wavelength == pytest.approx(WAVELENGTH, rel=0.03)


def test_the_line_with_the_largest_amplitude_gives_the_wavelength():
    positions = uniform(200)
    fading = sine(positions[:, 0]) * (1 - positions[:, 1] / WIDTH)
    across = 0.1e-3 * np.sin(2 * np.pi * positions[:, 1] / 10e-3)
    assert wrinkles(positions, fading + across).wavelength == pytest.approx(WAVELENGTH, rel=0.01)


def test_flat_and_tilted_surfaces_have_no_wave():
    for positions in (uniform(20), scattered(20)):
        assert wrinkles(positions, np.full(len(positions), -1e-3)) == Wrinkles(0.0, 0.0, 0.0, 0.0)
        rough = wrinkles(positions, 1e-12 * np.random.default_rng(2).uniform(-1, 1, len(positions)))
        assert (rough.wavelength, rough.misalignment, rough.curvature) == (0.0, 0.0, 0.0)
        tilted = wrinkles(positions, 0.02 * positions[:, 0])
        assert tilted.misalignment == pytest.approx(math.atan(0.02))
        assert tilted.curvature == pytest.approx(0.0, abs=1e-9)
        assert tilted.wavelength == 0.0
    line = np.linspace(0, LENGTH, 50)
    assert spectral_wavelength(line, 0.02 * line) == 0.0


def test_a_strip_of_one_line_and_a_round_surface_are_measured_too():
    strip = np.stack([np.linspace(0, LENGTH, 201), np.zeros(201)], axis=1)
    assert wrinkles(strip, sine(strip[:, 0])).wavelength == pytest.approx(WAVELENGTH, rel=1e-3)
    positions = scattered(120)
    disc = positions[np.hypot(positions[:, 0] - 0.05, positions[:, 1] - 0.025) < 0.025]
    measured = wrinkles(disc, sine(disc[:, 0]))
    assert measured.wavelength == pytest.approx(WAVELENGTH, rel=0.01)
    assert measured.misalignment == pytest.approx(ANGLE, rel=0.05)
    assert measured.curvature == pytest.approx(CURVATURE, rel=0.1)
