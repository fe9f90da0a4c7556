"""Contact pressures read back from the files add up to the forces."""

import csv

import meshio
import numpy as np
import pytest
from assembled import COMM

from ncf_fenicsx import Scene, run

QUIET = {"picture": False, "report": False}
ELASTIC = {"rate": {"kind": "none"}}
VTK_TOP, VTK_BOTTOM = [4, 5, 6, 7], [0, 1, 2, 3]


def read_back(folder, number):
    """Undeformed and current nodes in m, cells in VTK's order, fields at nodes, layers, and the row of history.csv."""
    mesh = meshio.read(sorted((folder / "fields").glob("*.vtu"))[number])
    with (folder / "history.csv").open() as file:
        row = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)][number]
    layer = mesh.cell_data_dict["layer"]["hexahedron"]
    return mesh.points, mesh.points + mesh.point_data["displacement"], mesh.cells_dict["hexahedron"], mesh, layer, row


def area_vectors(positions, quads):
    """Upward share of each node in the area of deformed quads, by the edges at their corners, in m2."""
    total = np.zeros_like(positions)
    for corner in range(4):
        here, ahead, behind = (quads[:, (corner + step) % 4] for step in (0, 1, -1))
        part = np.cross(positions[ahead] - positions[here], positions[behind] - positions[here]) / 4
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
        points, positions, cells, mesh, layer, row = read_back(folder, number)
        area = np.linalg.norm(area_vectors(positions, faces(points, cells, layer == 2, 4e-3)), axis=1)
        x = 8.2e-3 + (travelled if number == -1 else 0.0)
        axis = np.array([x, 0.0, 4e-3 - row["tool_displacement"] + 4e-3])
        radial = (positions - axis) * [1, 0, 1]
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
        points, positions, cells, mesh, layer, row = read_back(folder, number)
        for below in (1, 2, 3):
            quads = faces(points, cells, layer == below, 2e-3 * below)
            area = area_vectors(positions, quads)
            nodes = np.unique(quads)
            force = 4 * (mesh.point_data["contact_pressure"][nodes] * area[nodes, 2]).sum()
            carried = row["tool_force"] + row["weight"] * (3 - below) / 3
            assert force == pytest.approx(carried, rel=1e-6, abs=1e-9)
            if below < 3:
                largest = mesh.point_data["contact_pressure"][nodes].max()
                assert largest == row[f"interface_pressure_max_{below}"]
    assert row["tool_force"] > 0.4


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
