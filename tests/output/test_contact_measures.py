"""What is measured of contacts: pressures add up to forces; voids, slip, waves and contact width of imposed shapes."""

import csv
import math

import meshio
import numpy as np
import pytest
from assembled import COMM, assign, build

from ncf_fenicsx import Scene, run
from ncf_fenicsx.output.contact_measures import ContactMeasures

QUIET = {"picture": False}
ELASTIC = {"rate": {"kind": "none"}}
VTK_TOP, VTK_BOTTOM = [4, 5, 6, 7], [0, 1, 2, 3]


def read_back(folder, number):
    """Undeformed and current nodes in m, cells in VTK's order, fields at nodes, layers, and the row of history.csv."""
    mesh = meshio.read(sorted((folder / "fields").glob("*.vtu"))[number])
    with (folder / "history.csv").open() as file:
        row = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)][number]
    layer = mesh.cell_data_dict["layer"]["hexahedron"]
    return mesh.points, mesh.points + mesh.point_data["displacement"], mesh.cells_dict["hexahedron"], mesh, layer, row


def area_vectors(places, quads):
    """Upward share of each node in the area of deformed quads, by the edges at their corners, in m2."""
    total = np.zeros_like(places)
    for corner in range(4):
        here, ahead, behind = (quads[:, (corner + step) % 4] for step in (0, 1, -1))
        part = np.cross(places[ahead] - places[here], places[behind] - places[here]) / 4
        np.add.at(total, here, part)
    return total


def faces(points, cells, layer, height):
    """Quads of the cells of a layer whose undeformed upper face is at a height, counter-clockwise from above."""
    quads = cells[layer][:, VTK_TOP]
    return quads[np.isclose(points[quads][:, :, 2], height).all(axis=1)]


CONTACTS = {
    "penalty": {},
    "nitsche": {"contact": {"kind": "nitsche"}},
    "augmented_lagrangian": {"contact": {"kind": "augmented_lagrangian"}},
}


@pytest.mark.parametrize("way", CONTACTS)
@pytest.mark.parametrize("ranks_of_symmetry", [4, 2])
def test_the_pressure_field_times_the_current_area_is_the_force_on_a_roller(folder, way, ranks_of_symmetry):
    travelled = 1.5e-3
    path = [
        {"travel": ["0 mm", "0 mm", "-0.5 mm"], "speed": "1 mm/min"},
        {"travel": ["1.5 mm", "0 mm", "0 mm"], "speed": "0.5 mm/s"},
    ]
    sides = {} if ranks_of_symmetry == 4 else {"x_min": "fixed"}
    table = {
        "laws": ELASTIC | {"in_plane": {"modulus": "10 MPa"}},
        "stack": {
            "layers": 2,
            "size": ["16 mm", "6 mm"],
            "divisions": [32, 2],
            "grading": [0, 0],
            "focus": ["0 mm", "0 mm"],  # a node under the axis, else
            "sides": sides,
        },
        "tool": {"width": "infinite", "radius": "4 mm", "position": ["8.2 mm", "0 mm"], "path": path} | CONTACTS[way],
        "solver": {"first_step": "5 s", "largest_step": "10 s"},
        "output": QUIET,
    }
    result = run(Scene.from_table(table), folder)
    assert result.done, result.reason
    if COMM.rank:
        return
    for number in (2, -1):
        points, places, cells, mesh, layer, row = read_back(folder, number)
        area = np.linalg.norm(area_vectors(places, faces(points, cells, layer == 2, 4e-3)), axis=1)
        x = 8.2e-3 + (travelled if number == -1 else 0.0)
        axis = np.array([x, 0.0, 4e-3 - row["tool_displacement"] + 4e-3])
        radial = (places - axis) * [1, 0, 1]
        normal = -radial / np.linalg.norm(radial, axis=1)[:, None]  # from the fabric towards the axis
        pressure = mesh.point_data["contact_pressure"]
        force = ranks_of_symmetry * pressure * area @ normal
        assert row["tool_force"] > 0.01
        assert np.count_nonzero(pressure * area) >= 3
        assert force[2] == pytest.approx(row["tool_force"], rel=1e-6)
        assert np.any((pressure * area > 0) & (normal[:, 2] < 1 - 1e-4))  # not all under the axis
        top = np.isclose(points[:, 2], 4e-3)
        assert pressure[top].max() == row["pressure_max"]


@pytest.mark.parametrize("way", CONTACTS)
@pytest.mark.parametrize("divisions", [[8, 3], [[8, 3], [5, 4], [7, 2]]], ids=["matching", "different"])
def test_the_pressure_between_layers_carries_the_plate_and_the_layers_above(folder, divisions, way):
    table = {
        "laws": ELASTIC,
        "stack": {"layers": 3, "size": ["12 mm", "6 mm"], "divisions": divisions, "grading": [0.3, 0.2]},
        "interface": CONTACTS[way],
        "tool": {"kind": "plate", "path": [{"travel": ["0 mm", "0 mm", "-0.6 mm"], "speed": "2 mm/min"}]},
        "solver": {"force_tolerance": 1e-9, "first_step": "6 s", "largest_step": "6 s"},
        "output": QUIET,
    }
    result = run(Scene.from_table(table), folder)
    assert result.done, result.reason
    if COMM.rank:
        return
    for number in range(len(result.history)):
        points, places, cells, mesh, layer, row = read_back(folder, number)
        for below in (1, 2, 3):
            quads = faces(points, cells, layer == below, 2e-3 * below)
            area = area_vectors(places, quads)
            nodes = np.unique(quads)
            force = 4 * (mesh.point_data["contact_pressure"][nodes] * area[nodes, 2]).sum()
            carried = row["tool_force"] + row["weight"] * (3 - below) / 3
            assert force == pytest.approx(carried, rel=1e-6, abs=1e-9)
            if below < 3:
                largest = mesh.point_data["contact_pressure"][nodes].max()
                assert largest == row[f"interface_pressure_max_{below}"]
    assert row["tool_force"] > 0.4


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
        problem.commit(1.0)
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
    """To half an element at each end, also where the surface has moved and been stretched along x."""
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
    assert row["contact_width"] == pytest.approx(ends * half, abs=0.5 * ends * element)
    assert row["contact_width"] == pytest.approx(ends * (half // element + 0.5) * element, rel=1e-9)
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


def test_two_rollers_that_mirror_each_other_carry_alike(folder):
    """On the whole of a strip, pressed 0.3 mm apart in time: the second ends as the first did, and both are carried."""
    press, hold = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}, {"hold": "18 s"}
    roller = {"width": "infinite", "radius": "2.5 mm"}
    table = {
        "laws": ELASTIC,
        "stack": {
            "layers": 2,
            "size": ["24 mm", "4 mm"],
            "divisions": [24, 1],
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "x_max": "fixed"},
        },
        "tool": [
            roller | {"position": ["6 mm", "0 mm"], "path": [press, hold]},
            roller | {"position": ["18 mm", "0 mm"], "path": [hold, press]},
        ],
        "output": QUIET,
    }
    result = run(Scene.from_table(table), folder)
    assert result.done, result.reason
    half = next(row for row in result.history if row["time"] == pytest.approx(18.0))
    assert half["tool_force"] > 0.01
    assert half["tool_force_2"] < 1e-3 * half["tool_force"]
    for row in result.history:
        assert row["tool_force"] + row["tool_force_2"] + row["weight"] == pytest.approx(row["support_force"], rel=1e-6)
    last = result.history[-1]
    for name in ("tool_force", "pressure_max", "contact_width", "tool_displacement"):
        assert last[f"{name}_2"] == pytest.approx(last[name], rel=1e-5)
