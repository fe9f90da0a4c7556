"""Hertz's line contact, from `demos/verification/hertz.py`: half width, peak and profile of the pressure."""

import numpy as np
import pytest
from mpi4py import MPI
from program import DEMOS, script

pytestmark = pytest.mark.serial

COMM = MPI.COMM_WORLD
DEMO = DEMOS / "verification" / "hertz.py"


@pytest.fixture
def hertz():
    """The demo as a module."""
    return script(DEMO)


def test_a_cylinder_on_a_thick_block_is_hertz_s_line_contact(hertz, folder):
    scene, contact = hertz.press(folder)
    radius, depth = scene.tool[0].radius, -sum(segment.travel[2] for segment in scene.segments)
    a = contact.hertz_half_width
    assert a / radius < 0.05
    thickness = scene.stack.layers * scene.stack.thickness
    assert min(thickness, scene.stack.size[0]) > 20 * a
    assert a < 0.6 * np.sqrt(2 * radius * depth)  # the surface sinks around the cylinder, it does not cut it
    assert abs(contact.errors["half width"]) < 0.02
    assert abs(contact.errors["peak pressure"]) < 0.02
    if COMM.rank:
        return
    x, pressure = hertz.profile(hertz.read_last_fields(folder))
    assert len(x) >= 10
    assert 2 * np.trapezoid(pressure, x) == pytest.approx(contact.line_force, rel=0.02)
    inner = x < 0.9 * a
    assert pressure[inner] == pytest.approx(contact.pressure(x[inner]), abs=0.02 * contact.hertz_peak)
    slope, square = np.polyfit(x**2, pressure**2, 1)  # p^2 = p0^2 (1 - x^2 / a^2), whatever the ends
    assert np.sqrt(-square / slope) == pytest.approx(a, rel=0.01)
    assert np.sqrt(square) == pytest.approx(contact.hertz_peak, rel=0.01)
