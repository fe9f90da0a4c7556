"""Meshes that are right pass all checks: bent, of another outline, written in other ways."""

from dataclasses import replace

import numpy as np
import pytest
from gmsh_files import COMM, GOOD, binary, stack, text_22, text_41, write
from program import SMALL_STACK

from ncf_fenicsx import SceneError
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.hexahedra import check_cells
from ncf_fenicsx.mesh.mesh_checks import check_mesh
from ncf_fenicsx.mesh.msh_file import read_msh
from ncf_fenicsx.mesh.stack_file import read_stack
from ncf_fenicsx.scene.stack import Stack

pytestmark = pytest.mark.two_ranks

FREE = {"x_min": "fixed", "x_max": "free", "y_min": "free", "y_max": "free"}
TEXT = text_22(GOOD)
LATER = text_41(GOOD)


def same(one, two):
    return np.array_equal(one.points, two.points) and np.array_equal(one.cells, two.cells)


@pytest.mark.parametrize("content", [LATER, binary(TEXT), binary(LATER), TEXT.replace("\n", "\r\n"), "\ufeff" + TEXT])
def test_all_ways_to_write_a_mesh_give_the_same(content, folder):
    write(folder, TEXT)
    expected = read_stack(folder / "mesh.msh", 2)
    COMM.barrier()
    build_mesh(write(folder, content), COMM)
    found = read_stack(folder / "mesh.msh", 2)
    assert same(found, expected)
    assert np.array_equal(found.layer, expected.layer)
    assert np.array_equal(found.face_tags, expected.face_tags)


def corners(path):
    """Corners of all cells of a file, in an order that depends on nothing but their places."""
    read = read_stack(path, 2)
    return np.sort(read.points[read.cells].reshape(len(read.cells), -1), axis=0)


@pytest.mark.parametrize("text", [text_22, text_41], ids=["2.2", "4.1"])
def test_numbers_of_nodes_may_have_gaps_and_any_order(text, folder):
    order = np.random.default_rng(1).permutation(len(GOOD.tags))
    elements = [(kind, group, [100 + 7 * node for node in nodes]) for kind, group, nodes in GOOD.elements]
    mesh = replace(GOOD, elements=elements, tags=[100 + 7 * GOOD.tags[k] for k in order], points=GOOD.points[order])
    build_mesh(write(folder, text(mesh)), COMM)
    found = corners(folder / "mesh.msh")
    COMM.barrier()
    write(folder, TEXT)
    assert found == pytest.approx(corners(folder / "mesh.msh"), abs=0)


def test_elements_of_all_kinds_may_be_mixed_in_any_order(folder):
    """Rows of text are read as many at a time as are alike."""
    order = np.random.default_rng(2).permutation(len(GOOD.elements))
    mesh = replace(GOOD, elements=[(1, 1, [1, 2]), *(GOOD.elements[k] for k in order), (15, 1, [3])])
    build_mesh(write(folder, text_22(mesh)), COMM)
    rows = read_msh(folder / "mesh.msh")
    assert len(rows.elements[5]) == 12
    assert len(rows.elements[3]) == 2 * 6 + 2 * (2 * 3 + 2 * 2)


def bent(mesh, radius):
    """A stack rolled onto a cylinder along y below it, or above it where the radius (m) is negative."""

    def change(points):
        angle, distance = points[:, 0] / radius, radius + points[:, 2]
        return np.stack([distance * np.sin(angle), points[:, 1], distance * np.cos(angle) - radius], axis=1)

    return mesh.with_points(change)


def checked(path, layers, **sides):
    mesh = read_stack(path, layers)
    check_cells(mesh)
    check_mesh(Stack(layers=layers, mesh=str(path), sides=FREE | sides), mesh)


@pytest.mark.parametrize("own_nodes", [False, True])
@pytest.mark.parametrize("degrees", [20, 60, 80])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_bent_stack_passes(own_nodes, degrees, sign, folder):
    mesh = stack(own_nodes=own_nodes, divisions=(12, 2), thickness=0.5e-3)
    write(folder, text_41(bent(mesh, sign * 12e-3 / np.radians(degrees))))
    checked(folder / "mesh.msh", 2, x_min="symmetry", y_min="symmetry", y_max="symmetry")
    with pytest.raises(SceneError, match=r"the facet of 'x_max' .* mm off x = .* where the stack ends"):
        checked(folder / "mesh.msh", 2, x_max="symmetry")


def test_the_small_stack_of_gmsh_passes():
    checked(SMALL_STACK, 2, x_min="symmetry", y_min="symmetry")


def test_a_stack_of_another_outline_passes(folder):
    """Trapezoids, and a rounded side; their names still tell where they look."""
    skewed = stack().with_points(
        lambda points: points + np.outer(points[:, 1] * (points[:, 0] - 6e-3) / 12e-3, [1, 0, 0])
    )
    write(folder, text_22(skewed))
    checked(folder / "mesh.msh", 2, y_min="symmetry", y_max="symmetry")
