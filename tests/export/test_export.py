"""Files for other programs hold the numbers of the results; what cannot be written is one line, and no file."""

import csv
import re
import shutil
import subprocess

import h5py
import meshio
import numpy as np
import pytest
from program import call

from ncf_fenicsx import Scene, run
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.export.command import FORMATS, Order, carry_out
from ncf_fenicsx.export.deformed import Deformed, fibre_axes
from ncf_fenicsx.export.files import classes
from ncf_fenicsx.export.lcmsim import card_number
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial

PLATE = {
    "stack": {"layers": 2, "size": ["10 mm", "5 mm"], "divisions": [4, 2], "grading": [0.0, 0.0]},
    "tool": {"kind": "plate", "path": [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]},
    "interface": {"kind": "bonded"},
    "solver": {"largest_step": "6 s"},
}


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    """Results without permeability, of a stack under a plate."""
    folder = tmp_path_factory.mktemp("flat") / "run"
    run(Scene.from_table(PLATE | {"output": {"picture": False, "report": False}}), folder)
    return folder


@pytest.fixture(scope="module")
def flat_permeable(tmp_path_factory):
    """The same with permeability."""
    folder = tmp_path_factory.mktemp("flat_permeable") / "run"
    run(Scene.from_table(PLATE | {"output": {"picture": False, "report": False, "permeability": {}}}), folder)
    return folder


@pytest.fixture
def last(results):
    """Last field file of the run, read by meshio alone."""
    return meshio.read(sorted((results / "fields").glob("*.vtu"))[-1])


def exported(results, to, out, time=None):
    carry_out(Order(results, to, out, time))
    return out


def columns(path):
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name not in ("name", "type")}


def cell_values(mesh, name):
    return mesh.cell_data_dict[name]["hexahedron"]


def test_tables_have_the_fields_to_the_last_digit(results, last, folder):
    out = exported(results, "csv", folder / "out")
    nodes, cells = columns(out / "nodes.csv"), columns(out / "cells.csv")
    assert np.array_equal(
        np.column_stack([nodes[axis] for axis in "xyz"]), last.points + last.point_data["displacement"]
    )
    assert np.array_equal(nodes["contact_pressure"], last.point_data["contact_pressure"])
    for name in ("volume_fraction", "permeability_along", "permeability_across", "layer"):
        assert np.array_equal(cells[name], cell_values(last, name)), name
    assert np.array_equal(cells["porosity"], 1 - cells["volume_fraction"])
    corners = np.column_stack([cells[f"node_{number}"] for number in range(1, 9)]) - 1
    assert np.array_equal(corners, last.cells_dict["hexahedron"])


def test_thickness_is_that_of_the_pressed_cells(results, folder):
    cells = columns(exported(results, "csv", folder / "out") / "cells.csv")
    assert cells["reference_thickness"] == pytest.approx(2e-3, rel=1e-9)
    vf0 = Scene.read(results / "scene.toml").stack.initial_volume_fraction
    stretch = cells["thickness"] / cells["reference_thickness"]
    assert cells["volume_fraction"] == pytest.approx(vf0 / stretch, rel=2e-3)  # mean in the cell, and in its middle
    assert stretch.min() < 0.97


def test_permeability_has_the_direction_of_the_fibres(results, folder):
    cells = columns(exported(results, "csv", folder / "out") / "cells.csv")
    assert np.array_equal(cells["permeability_1"], cells["permeability_along"])
    assert np.array_equal(cells["permeability_2"], cells["permeability_across"])
    assert np.array_equal(cells["permeability_3"], cells["permeability_across"])
    assert np.degrees(np.arctan2(cells["axis_1_y"], cells["axis_1_x"])) == pytest.approx(30, abs=1)
    first, third = (np.column_stack([cells[f"axis_{n}_{axis}"] for axis in "xyz"]) for n in (1, 3))
    assert np.linalg.norm(first, axis=1) == pytest.approx(1)
    assert np.einsum("ij,ij->i", first, third) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("in_plane", "share", "angle"),
    [
        ({"kind": "neo_hookean"}, 0.5, 0.0),
        ({"kind": "fibre_families", "plies": [90.0]}, 1.0, 90.0),
        ({"kind": "fibre_families", "plies": [0.0, 90.0]}, 0.5, 0.0),
        ({"kind": "fibre_families", "plies": [0.0, 0.0, 0.0, 90.0]}, 0.75, 0.0),
        ({"kind": "fibre_families", "plies": [20.0, -20.0]}, np.cos(np.radians(20)) ** 2, 0.0),
    ],
)
def test_plies_side_by_side_have_the_axes_of_their_mean(in_plane, share, angle):
    shares, angles = fibre_axes(Scene.from_table({"duration": "1 s", "laws": {"in_plane": in_plane}}))
    assert shares == pytest.approx(share)
    assert np.abs(np.degrees(angles)) == pytest.approx(angle, abs=1e-9)


def test_an_abaqus_deck_reads_back(results, last, folder):
    deck = exported(results, "abaqus", folder / "out") / "deformed.inp"
    mesh = meshio.abaqus.read(deck)
    assert mesh.points == pytest.approx(last.points + last.point_data["displacement"], rel=1e-11, abs=1e-18)
    assert np.array_equal(mesh.cells_dict["hexahedron"], last.cells_dict["hexahedron"])
    text = deck.read_text("ascii")
    states = text.split("TYPE=SOLUTION\n")[1].splitlines()
    assert [float(row.split(",")[1]) for row in states] == pytest.approx(
        cell_values(last, "volume_fraction"), rel=1e-11
    )
    for number in (1, 2):
        members = re.search(rf"ELSET=LAYER_{number}\n([\d, \n]+)", text)[1]
        of_layer = np.flatnonzero(cell_values(last, "layer") == number) + 1
        assert [int(word) for word in re.findall(r"\d+", members)] == of_layer.tolist()


def test_a_vtkhdf_file_reads_back(results, last, folder):
    with h5py.File(exported(results, "vtkhdf", folder / "out") / "deformed.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"UnstructuredGrid"
        assert np.array_equal(root["Points"], last.points + last.point_data["displacement"])
        assert np.array_equal(np.reshape(root["Connectivity"], (-1, 8)), last.cells_dict["hexahedron"])
        assert root["Offsets"][-1] == root["NumberOfConnectivityIds"][0]
        assert np.array_equal(root["PointData/displacement"], last.point_data["displacement"])
        assert np.array_equal(root["CellData/volume_fraction"], cell_values(last, "volume_fraction"))


def test_an_lcmsim_part_table_holds_the_stack(results, folder):
    out = exported(results, "lcmsim", folder / "out")
    parts = columns(out / "part_description.csv")
    assert parts["part_id"].tolist() == list(range(1, len(parts["part_id"]) + 1))
    mesh = [line for line in (out / "mesh.bdf").read_text().splitlines() if line.startswith(("GRID", "CTRIA3"))]
    points = np.array([[float(line[start : start + 8]) for start in (24, 32, 40)] for line in mesh if line[0] == "G"])
    triangles = np.array([[int(line[a : a + 8]) for a in (16, 24, 32, 40)] for line in mesh if line[0] == "C"])
    assert len(points) == 7 * 3
    assert len(triangles) == 2 * 6 * 2
    corners = points[triangles[:, 1:] - 1]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    thickness, porosity = (parts[name][triangles[:, 0] - 1] for name in ("thickness", "porosity"))
    cells = columns(exported(results, "csv", folder / "csv") / "cells.csv")
    fibres = 12e-3 * 6e-3 * 2 * 2e-3 * Scene.read(results / "scene.toml").stack.initial_volume_fraction
    assert areas @ (thickness * (1 - porosity)) == pytest.approx(fibres, rel=2e-3)
    assert parts["permeability_Z"].min() > cells["permeability_across"].min()
    assert parts["permeability_Z"].max() < cells["permeability_across"].max()
    assert (parts["alpha"] * parts["permeability"]).max() < cells["permeability_across"].max() * (1 + 1e-9)
    assert np.degrees(np.arctan2(parts["refdir2"], parts["refdir1"])) == pytest.approx(30, abs=1)


def test_an_even_stack_is_one_part(flat_permeable, folder):
    parts = columns(exported(flat_permeable, "lcmsim", folder / "out") / "part_description.csv")
    cells = columns(exported(flat_permeable, "csv", folder / "csv") / "cells.csv")
    assert parts["thickness"] == pytest.approx(3.8e-3, rel=1e-3)
    assert parts["permeability"] == pytest.approx(
        (cells["permeability_along"] + cells["permeability_across"])[0] / 2, rel=1e-3
    )
    assert parts["alpha"] == pytest.approx(1)
    assert parts["refdir1"] == pytest.approx(1)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_solves_the_deck(flat_permeable, folder):
    check_calculix(exported(flat_permeable, "calculix", folder / "out"))


def check_calculix(out):
    """CalculiX ends well, and pressure falls in a straight line along x."""
    ended = subprocess.run(["ccx", "darcy"], cwd=out, capture_output=True, text=True, check=False)
    assert "Job finished" in ended.stdout, ended.stdout[-500:]
    deck = meshio.abaqus.read(out / "darcy.inp")
    rows = [line.split() for line in (out / "darcy.dat").read_text().splitlines()]
    pressure = np.array([float(row[1]) for row in rows if len(row) == 2 and row[0].isdigit()])
    x = deck.points[:, 0]
    assert pressure == pytest.approx(1 - (x - x.min()) / np.ptp(x), abs=1e-5)


def test_a_deck_for_calculix_has_the_permeabilities_as_conductivities(flat_permeable, folder):
    text = (exported(flat_permeable, "calculix", folder / "out") / "darcy.inp").read_text("ascii")
    cells = columns(exported(flat_permeable, "csv", folder / "csv") / "cells.csv")
    found = [float(word) for word in re.search(r"TYPE=ORTHO\n(.*)\n", text)[1].split(",")]
    assert found == pytest.approx([1e12 * cells[f"permeability_{axis}"][0] for axis in (1, 2, 3)], rel=1e-3)
    sections = re.findall(r"\*ELSET, ELSET=L\d+_\d+\n([\d, \n]+)", text)
    assert sorted(int(word) for part in sections for word in re.findall(r"\d+", part)) == list(range(1, 17))


def test_another_step_can_be_asked_for(results, folder):
    first, last = (Deformed.read(Results.read(results), time) for time in (0.0, None))
    assert first.time < 1 < last.time
    assert np.abs(first.displacement).max() < np.abs(last.displacement).max() / 10
    assert carry_out(Order(results, "csv", folder / "out", "0.1 s")).startswith("state at 0 s")


@pytest.mark.parametrize("to", ["abaqus", "vtkhdf", "csv"])
def test_results_without_permeability_are_written_without(flat, folder, to):
    out = exported(flat, to, folder / "out")
    text = b"".join(path.read_bytes() for path in out.iterdir())
    assert b"permeability" not in text


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["{flat}", "--to", "lcmsim"], "the results have no permeability; expected results of a scene with"),
        (["{flat}", "--to", "calculix"], "the results have no permeability"),
        (["{flat}", "--to", "ansys"], "--to ansys: expected abaqus, calculix, vtkhdf, lcmsim, csv"),
        (["{flat}", "--to", "csv", "--time", "3"], "--time 3: expected a time with its unit"),
        (["nowhere", "--to", "csv"], "nowhere: has no scene.toml; expected a results folder"),
    ],
)
def test_mistakes_are_one_line_and_nothing_is_written(flat, folder, words, complaint):
    ended = call("export", *[word.format(flat=flat) for word in words], "--out", folder / "out", folder=folder)
    assert ended.returncode == 2
    assert ended.stderr.count("\n") == 1
    assert complaint in ended.stderr
    assert not (folder / "out").exists()


def test_a_broken_field_file_is_named(results, folder):
    copy = shutil.copytree(results, folder / "copy")
    broken = sorted((copy / "fields").glob("*.vtu"))[-1]
    broken.write_bytes(broken.read_bytes()[:200])
    with pytest.raises(SceneError, match=re.escape(broken.name)):
        carry_out(Order(copy, "csv", folder / "out", None))


def test_a_folder_without_fields_is_named(results, folder):
    copy = shutil.copytree(results, folder / "copy")
    (copy / "fields.pvd").unlink()
    for to in FORMATS:
        with pytest.raises(SceneError, match=r"has no fields\.pvd"):
            carry_out(Order(copy, to, folder / "out", None))


@pytest.mark.parametrize("value", [0.0, 1.0, 0.0381234567, -0.0381234567, 1.23456e-5, -1.23456e-5, 12.3456789, -1e-12])
def test_numbers_of_cards_fit_their_field(value):
    text = card_number(value)
    assert len(text) <= 8
    assert float(text) == pytest.approx(value, rel=2e-2, abs=5e-8)


def test_classes_are_few_and_none_is_empty():
    values = np.array([0.4, 0.4 + 1e-12, 0.9, 0.41, 0.4])
    assert classes(values, 10).tolist() == [0, 0, 1, 0, 0]
    assert classes(np.full(3, 0.4), 10).tolist() == [0, 0, 0]
