"""Meshes from gmsh: the same history as the extruded stack, and what is wrong with a file."""

import meshio
import numpy as np
import pytest
from mpi4py import MPI
from program import SMALL_STACK

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mesh import build_mesh, hexahedra
from ncf_fenicsx.mesh.hexahedra import Hexahedra, lower_tag, upper_tag
from ncf_fenicsx.mesh.stack_file import read_stack

COMM = MPI.COMM_WORLD


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["one_sided", pytest.param("bonded", marks=pytest.mark.two_ranks)])
def test_a_gmsh_file_gives_the_history_of_the_extruded_stack_on_the_same_nodes(kind, order, folder):
    table = {
        "tool": {"width": "infinite", "path": [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]},
        "interface": {"kind": kind},
        "output": {"picture": False, "report": False},
        "solver": {"time_tolerance": 1.0},  # else steps after the first touch have next to no pressure
    }
    extruded = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0.0, 0.0]}
    extruded["order"] = order
    one = run(Scene.from_table(table | {"stack": extruded}), folder / "extruded").history
    two = run(
        Scene.from_table(table | {"stack": {"layers": 2, "mesh": str(SMALL_STACK), "order": order}}), folder / "gmsh"
    ).history
    assert len(one) == len(two) > 5
    assert one[-1]["tool_force"] > 0
    for first, second in zip(one, two, strict=True):
        for name in set(first) - {"wall_time", "newton_iterations"}:
            assert second[name] == pytest.approx(first[name], rel=1e-8, abs=1e-13), name


def altered(path, change, **tables):
    """Copy of the small gmsh mesh with one thing wrong, on rank 0; the same path on all."""
    if COMM.rank == 0:
        mesh = meshio.read(SMALL_STACK, file_format="gmsh")
        change(mesh)
        meshio.write(path, mesh, file_format="gmsh22", binary=False)
    COMM.barrier()
    return Scene.from_table({"tool": {}, "stack": {"layers": 2, "mesh": str(path)}} | tables)


def _physical(mesh, shape):
    return next(
        data for block, data in zip(mesh.cells, mesh.cell_data["gmsh:physical"], strict=True) if block.type == shape
    )


def _name(mesh, name):
    return mesh.field_data[name][0]


def invert(mesh):
    cells = next(block.data for block in mesh.cells if block.type == "hexahedron")
    cells[3] = cells[3][[4, 5, 6, 7, 0, 1, 2, 3]]


def flatten(mesh):
    mesh.points[:, 2] *= np.where(mesh.points[:, 2] > 3e-3, 0.5, 1.0)


def thin(mesh):
    mesh.points[:, 2] *= 0.5


def bend(mesh):
    mesh.points[:, 2] -= mesh.points[:, 0] ** 2


def forget_a_facet(mesh):
    for number, block in enumerate(mesh.cells):
        if block.type == "quad":
            mesh.cells[number].data = block.data[1:]
            for data in mesh.cell_data.values():
                data[number] = data[number][1:]
            return


def rename(old, new):
    def change(mesh):
        mesh.field_data[new] = mesh.field_data.pop(old)

    return change


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (invert, "is inverted"),
        (flatten, "is degenerate"),
        (thin, "is 1 mm thick on average; expected stack.thickness = 2 mm"),
        (bend, "the bottom is not flat"),
        (forget_a_facet, "has no tag"),
        (rename("layer_2", "layer_7"), "no physical volume 'layer_2'"),
        (rename("top", "lid"), "is in 'lid'"),
        (rename("x_min", "sides"), "no facets named 'x_min'"),
        (lambda mesh: mesh.field_data.update(layer_9=mesh.field_data.pop("layer_1")), "no physical volume 'layer_1'"),
    ],
)
def test_what_is_wrong_with_a_mesh_is_named_in_one_line(change, expected, folder):
    scene = altered(folder / "wrong.msh", change)
    with pytest.raises(SceneError) as caught:
        build_mesh(scene, COMM)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def lay_down(mesh):
    cells = next(block.data for block in mesh.cells if block.type == "hexahedron")
    cells[3] = cells[3][[0, 3, 7, 4, 1, 2, 6, 5]]  # the same cell, its axes one further


def test_bending_apart_needs_elements_as_high_as_their_layer(folder):
    build_mesh(altered(folder / "upright.msh", lambda _: None, laws={"bending": {}}), COMM)
    with pytest.raises(SceneError, match=r"cell 3 is 0 mm high along its third axis; expected one element through"):
        build_mesh(altered(folder / "lying.msh", lay_down, laws={"bending": {}}), COMM)


def test_order_2_needs_elements_that_stand_in_their_layer(folder):
    file = folder / "lying.msh"
    scene = altered(file, lay_down, stack={"layers": 2, "mesh": str(file), "order": 2})
    with pytest.raises(SceneError, match=r"cell 3 at \(.*\) mm lies on its side; expected cells with their third axis"):
        build_mesh(scene, COMM)


def test_cells_in_a_volume_that_is_no_layer_are_named(folder):
    def stray(mesh):
        mesh.field_data["stray"] = np.array([99, 3])
        _physical(mesh, "hexahedron")[0] = 99

    with pytest.raises(SceneError, match="is in 'stray'"):
        build_mesh(altered(folder / "wrong.msh", stray), COMM)


def test_layers_that_share_nodes_are_split_and_separate_ones_bonded():
    shared = read_stack(SMALL_STACK, 2)
    split = hexahedra.split_layers(shared, np.array([0, 1]))
    bonded = hexahedra.bond_layers(split)
    assert len(split.points) == len(shared.points) + 7 * 3
    assert len(bonded.points) == len(shared.points)
    marked = hexahedra.mark_interfaces(split, np.array([0, 1]))
    assert np.bincount(marked.face_tags.ravel())[[lower_tag(0), upper_tag(0)]] == pytest.approx(12)
    assert isinstance(bonded, Hexahedra)
