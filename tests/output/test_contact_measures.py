"""What is measured of contacts, on imposed shapes: voids, slip, waves and contact width."""

import math

import numpy as np
import pytest
from assembled import assign, build, step_of

from ncf_fenicsx.output.contact_measures import ContactMeasures

LENGTH, WIDTH = 60e-3, 6e-3


def strip(layers=2, sides=None, elements=120, **keys):
    stack = {"layers": layers, "size": ["60 mm", "6 mm"], "divisions": [elements, 2], "grading": [0, 0]}
    problem, _ = build({"stack": stack | {"sides": sides or {}}, "duration": "1 s"} | keys)
    return problem


def in_upper(problem):
    """Which local nodes lie in the upper of two layers."""
    facing = np.isin(problem.contacts.body.spaces.numbers, problem.contacts.layers[0].pairing.masters)
    return facing | (problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3)


def observed(problem):
    problem.contacts.refresh()
    return ContactMeasures(problem).observe()


SIDES = {
    "a quarter": ({}, 4, 2, 2),
    "a half": ({"x_min": "fixed"}, 2, 1, 2),
    "the whole": ({"x_min": "fixed", "y_min": "free"}, 1, 1, 1),
    "three planes": ({"y_max": "symmetry"}, 8, 2, 4),
}
"""Sides, copies of the modelled part, and how many times longer the whole is along x and y."""


@pytest.mark.parametrize("name", SIDES)
def test_a_sinusoidal_gap_has_its_volume_width_and_length(name):
    """A void at x = 0 up to the first zero of a cosine; as a wave of gaps A cos^2 it is cut off at the tolerance."""
    sides, copies, along_x, along_y = SIDES[name]
    problem = strip(sides=sides)
    x = problem.space.tabulate_dof_coordinates()[:, 0]
    lift = np.where(x < 20e-3, 0.4e-3 * np.cos(np.pi * x / 40e-3) ** 2, 0.0) - np.where(x < 20e-3, 0, 1e-6)
    problem.displacement.x.array.reshape(-1, 3)[:, 2] = np.where(in_upper(problem), lift, 0.0)
    row = observed(problem)
    assert row["gap_max_1"] == pytest.approx(0.4e-3, rel=1e-9)
    assert row["void_volume_1"] == pytest.approx(copies * 0.2e-3 * 20e-3 * WIDTH, rel=1e-6)
    border = 40e-3 / math.pi * math.acos(math.sqrt(0.02e-3 / 0.4e-3))
    longest = max(along_x * border, along_y * WIDTH)
    assert row["void_longest_1"] == pytest.approx(longest, rel=2e-3)
    assert row["interface_penetration_max_1"] == pytest.approx(1e-6, rel=1e-6)
    assert row["slip_max_1"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", SIDES)
def test_a_void_away_from_the_planes_is_as_long_as_it_is(name):
    sides, copies, _, along_y = SIDES[name]
    problem = strip(sides=sides)
    x, y, _ = problem.space.tabulate_dof_coordinates().T
    bump = np.where(abs(x - 30e-3) < 15e-3, 0.4e-3 * np.cos(np.pi * (x - 30e-3) / 30e-3) ** 2, 0.0)
    problem.displacement.x.array.reshape(-1, 3)[:, 2] = np.where(in_upper(problem), bump, 0.0)
    row = observed(problem)
    border = 2 * 30e-3 / math.pi * math.acos(math.sqrt(0.02e-3 / 0.4e-3))
    assert row["void_longest_1"] == pytest.approx(max(border, along_y * WIDTH), rel=2e-3)
    assert row["void_volume_1"] == pytest.approx(copies * 0.2e-3 * 30e-3 * WIDTH, rel=1e-6)
    assert np.ptp(y) == pytest.approx(WIDTH)


def test_an_imposed_slip_adds_up_over_steps():
    problem = strip(elements=20)
    upper, values = in_upper(problem), problem.displacement.x.array.reshape(-1, 3)
    for number in range(1, 5):
        values[:] = 0.0
        values[upper] = (0.24e-3 * number, -0.18e-3 * number, -1e-6)
        values[:, 0] -= 1e-3 * number  # together: no slip
        row = observed(problem)
        assert row["slip_max_1"] == pytest.approx(0.3e-3 * number, rel=1e-6)
        step_of(problem).commit()
    values[upper, :2] -= [0.24e-3 * 4, -0.18e-3 * 4]
    assert observed(problem)["slip_max_1"] == pytest.approx(0.0, abs=1e-9)


AMPLITUDE, WAVE = 0.5e-3, 12e-3


@pytest.mark.parametrize("ways", [["one_sided", "one_sided"], ["bonded", "bonded"], ["one_sided", "bonded"]])
@pytest.mark.parametrize(("phase", "sides"), [(0.0, {}), (0.4, {"x_min": "fixed"}), (-math.pi / 2, {"x_min": "fixed"})])
def test_a_sine_of_the_whole_stack_has_its_amplitude_angle_curvature_and_wavelength(phase, sides, ways):
    """Five waves on a strip; a cosine is smooth at a symmetry plane, beyond which it goes on."""
    problem = strip(layers=3, sides=sides, elements=240, interface=[{"kind": way} for way in ways])
    k = 2 * math.pi / WAVE
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], AMPLITUDE * np.cos(k * x[0] + phase)]))
    row = observed(problem)
    for number in (1, 2):
        assert row[f"wrinkle_amplitude_{number}"] == pytest.approx(AMPLITUDE, rel=1e-2)
        assert row[f"misalignment_max_{number}"] == pytest.approx(math.atan(AMPLITUDE * k), rel=1e-2)
        assert row[f"curvature_max_{number}"] == pytest.approx(AMPLITUDE * k**2, rel=1e-2)
        assert row[f"wrinkle_wavelength_{number}"] == pytest.approx(WAVE, rel=1e-2)
        assert (f"gap_max_{number}" in row) == (ways[number - 1] == "one_sided")
        assert row.get(f"gap_max_{number}", 0.0) < 1e-6
        assert row.get(f"void_longest_{number}", 0.0) == 0.0


def test_a_wave_is_whole_only_with_its_image():
    """Three quarters of a wave on the model: two crossings of the mean need the image beyond the symmetry plane."""
    found = {}
    for name, sides in {"mirrored": {}, "alone": {"x_min": "fixed"}}.items():
        problem = strip(sides=sides)
        k = 1.5 * math.pi / LENGTH / 2
        assign(problem, lambda x, k=k: np.stack([0 * x[0], 0 * x[0], AMPLITUDE * np.cos(k * x[0])]))
        found[name] = observed(problem)["wrinkle_wavelength_1"]
    assert found["alone"] == 0.0
    assert found["mirrored"] > 0.05


def test_waves_across_are_measured_along_y():
    stack = {"layers": 2, "size": ["6 mm", "60 mm"], "divisions": [2, 240], "grading": [0, 0]}
    problem, _ = build({"stack": stack, "duration": "1 s"})
    k = 2 * math.pi / WAVE
    assign(problem, lambda x: np.stack([0 * x[0], 0 * x[0], AMPLITUDE * np.cos(k * x[1])]))
    row = observed(problem)
    assert row["wrinkle_wavelength_1"] == pytest.approx(WAVE, rel=1e-2)
    assert row["misalignment_max_1"] == pytest.approx(math.atan(AMPLITUDE * k), rel=1e-2)


@pytest.mark.parametrize(("name", "at"), [("a quarter", 0.0), ("a half", 30e-3), ("the whole", 30e-3), ("a half", 0.0)])
@pytest.mark.parametrize("lowered", [0.0, 0.3e-3])
def test_a_cylinder_in_a_flat_surface_is_as_wide_as_its_chord(name, at, lowered):
    """To a tenth of an element at each end, also where the surface has moved and been stretched along x."""
    sides, _, along_x, along_y = SIDES[name]
    radius, depth, stretch = 5e-3, 0.21e-3, 0.0 if lowered == 0.0 else 0.05
    tool = {"radius": "5 mm", "width": "infinite", "position": [f"{at} m", "0 mm"], "path": [{"hold": "1 s"}]}
    stack = {"layers": 1, "size": ["60 mm", "6 mm"], "divisions": [300, 1], "grading": [0, 0], "sides": sides}
    problem, _ = build({"stack": stack, "tool": tool, "gravity": "0 m/s^2"})
    assign(problem, lambda x: np.stack([stretch * (x[0] - at), 0 * x[0], -lowered * x[2] / 2e-3]))
    problem.contacts.tools[0].tip.value[2] = 2e-3 - lowered - depth
    half = math.sqrt(2 * radius * depth - depth**2)
    row = ContactMeasures(problem).observe()
    element = LENGTH / 300 * (1 + stretch)
    ends = 1 if at == 0.0 and along_x == 1 else 2
    assert row["contact_width"] == pytest.approx(ends * half, abs=0.1 * ends * element)
    assert row["contact_length"] == pytest.approx(along_y * WIDTH, rel=1e-9)
    assert row["penetration_max"] == pytest.approx(depth, rel=1e-6)
    assert row["pressure_max"] == pytest.approx(
        problem.scene.tool[0].penalty.resolve(problem.scene.natural_stiffness) * depth / (1 + stretch), rel=1e-6
    )


def test_without_contact_there_is_no_width():
    tool = {"radius": "5 mm", "clearance": "0.1 mm", "path": [{"hold": "1 s"}]}
    problem, _ = build({"stack": {"layers": 1, "divisions": [6, 2], "size": ["12 mm", "6 mm"]}, "tool": tool})
    row = ContactMeasures(problem).observe()
    assert [row[name] for name in ("pressure_max", "contact_width", "contact_length", "penetration_max")] == [0.0] * 4
