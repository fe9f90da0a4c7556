"""Voids and the extent of contact against surfaces whose answers are known."""

import math

import numpy as np
import pytest
from flat_grids import grid

from ncf_fenicsx.output.voids import contact_extent, voids

pytestmark = pytest.mark.serial


def cap(positions, centre, radius, height):
    """A paraboloid gap, below zero outside the radius; its volume is pi radius^2 height / 2."""
    return height * (1 - ((positions - centre) ** 2).sum(axis=1) / radius**2)


def test_a_paraboloid_void_has_its_volume_and_length():
    radius, height, tolerance = 0.02, 1e-3, 0.1e-3
    errors = []
    for n in (25, 50, 100):
        positions, quads, area = grid(np.linspace(0, 0.06, n), np.linspace(0, 0.05, n))
        measured = voids(positions, quads, cap(positions, (0.03, 0.025), radius, height), area, tolerance)
        exact = math.pi * radius**2 * height / 2, 2 * radius * math.sqrt(1 - tolerance / height), height
        found = measured.volume, measured.longest, measured.widest_opening
        errors.append([abs(a / b - 1) for a, b in zip(found, exact, strict=True)])
    assert np.all(np.array(errors[-1]) < 1e-3), errors
    assert (
        voids(positions, quads[:, [1, 0, 3, 2]], cap(positions, (0.03, 0.025), radius, height), area, 1e-4) == measured
    )


def test_of_two_voids_the_longer_one_counts_and_their_volumes_add():
    positions, quads, area = grid(np.linspace(0, 0.1, 201), np.linspace(0, 0.05, 101))
    gap = np.maximum(cap(positions, (0.02, 0.025), 0.01, 1e-3), cap(positions, (0.07, 0.025), 0.02, 0.5e-3))
    measured = voids(positions, quads, gap, area, 1e-6)
    assert measured.longest == pytest.approx(0.04, rel=5e-3)
    assert measured.volume == pytest.approx(math.pi / 2 * (0.01**2 * 1e-3 + 0.02**2 * 0.5e-3), rel=2e-3)
    assert measured.widest_opening == pytest.approx(1e-3)


def test_voids_that_touch_at_a_corner_of_a_quad_are_two():
    positions, quads, area = grid(np.arange(5.0), np.arange(5.0))
    gap = np.full(25, -1.0)
    gap[[6, 12]] = 1.0  # at (1, 1) and (2, 2)
    assert voids(positions, quads, gap, area, 0.0).longest == pytest.approx(1.0)
    gap[7] = 1.0
    assert voids(positions, quads, gap, area, 0.0).longest == pytest.approx(2.0)


def test_a_closed_surface_has_no_void_and_an_open_one_no_contact():
    positions, quads, area = grid(np.linspace(0, 0.1, 5), np.linspace(0, 0.05, 4))
    shut = voids(positions, quads, np.full(20, -1e-6), area, 1e-6)
    assert (shut.volume, shut.longest, shut.widest_opening) == (0.0, 0.0, 0.0)
    assert contact_extent(positions, quads, np.full(20, 1e-6)) == (0.0, 0.0)
    assert contact_extent(positions, quads, np.zeros(20)) == pytest.approx((0.1, 0.05))
    assert voids(positions, quads, np.full(20, 1e-3), area, 1e-6).longest == pytest.approx(0.1)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_cylinder_touches_over_the_width_of_its_parabola(flipped):
    radius, depth = 0.05, 0.2e-3
    width, errors, spacings = 2 * math.sqrt(2 * radius * depth), [], []
    for n in (20, 40, 80, 160):
        x = np.linspace(-0.02, 0.02, n + 1)
        positions, quads, _ = grid(x, np.linspace(0, 0.03, 7))
        quads = quads[:, [1, 0, 3, 2]] if flipped else quads
        along_x, along_y = contact_extent(positions, quads, positions[:, 0] ** 2 / (2 * radius) - depth)
        assert along_y == pytest.approx(0.03)
        errors.append(abs(along_x - width))
        spacings.append(x[1] - x[0])
    assert errors[-1] < 1e-3 * width
    # chord of a parabola: the border is off by at most h^2/8 w'' / slope
    assert all(error <= 2 * h**2 / (4 * width) for error, h in zip(errors, spacings, strict=True))


def test_a_zone_of_one_node_reaches_to_the_crossings_of_its_edges():
    positions, quads, _ = grid(np.arange(3.0), np.arange(3.0))
    gap = np.full(9, 3.0)
    gap[4] = -1.0
    assert contact_extent(positions, quads, gap) == pytest.approx((0.5, 0.5))
