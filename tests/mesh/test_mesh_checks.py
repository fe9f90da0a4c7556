"""Mesh files with one defect each, and the one line that names it; and good files, bent and turned over, that pass."""

import re
from dataclasses import replace

import gmsh_files
import numpy as np
import pytest
from gmsh_files import binary, stack, text_22, text_41
from mpi4py import MPI
from program import SMALL_STACK, call

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.gmsh import read_gmsh
from ncf_fenicsx.mesh.hexahedra import check_cells
from ncf_fenicsx.mesh.mesh_checks import check_mesh
from ncf_fenicsx.mesh.msh_file import read_msh
from ncf_fenicsx.mesh.stack_mesh import stack_of
from ncf_fenicsx.scene.stack import Stack

COMM = MPI.COMM_WORLD
GOOD = stack()
FREE = {"x_min": "fixed", "x_max": "free", "y_min": "free", "y_max": "free"}
SCENE = """
duration = "1 s"
[stack]
layers = 2
mesh = "mesh.msh"
"""


def swap(one, two):
    """Groups with their names exchanged."""
    exchanged = {one: two, two: one}
    return GOOD.regroup(lambda name, _: exchanged.get(name, name))


def move(axis, size, where=lambda points: np.full(len(points), True)):
    """Nodes moved along an axis by a size (m)."""

    def change(points):
        points[where(points), axis] += size
        return points

    return GOOD.with_points(change)


def turned(degrees):
    """The stack turned about z."""
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return GOOD.with_points(lambda points: points @ turn)


def renumbered(change):
    """A file whose nodes have other numbers where they are listed, but not in the elements."""
    return replace(GOOD, tags=[change(tag) for tag in GOOD.tags])


def one_cell(change):
    """Groups changed for the first cell above (2, 1.5, 1) mm alone."""
    return GOOD.regroup(lambda name, at: change(name) if np.allclose(at[:2], (2, 1.5)) else name)


def only(name, other, limit):
    """Facets of a group whose centre has a coordinate x above a limit (mm) in another group, or in none."""
    return GOOD.regroup(lambda group, at: other if group == name and at[0] > limit else group)


def in_order(*layers):
    """Three layers with nodes of their own, named in another order from the bottom up."""
    names = {f"layer_{number + 1}": f"layer_{layer}" for number, layer in enumerate(layers)}
    return stack(3, own_nodes=True).regroup(lambda name, _: names.get(name, name))


def apart(size):
    """Layers with nodes of their own, the upper one raised by a size (m)."""
    mesh = stack(own_nodes=True)
    points = mesh.points.copy()
    points[len(points) // 2 :, 2] += size
    return replace(mesh, points=points)


TEXT = text_22(GOOD)
LATER = text_41(GOOD)
GROUPS = {
    "bottom and top exchanged": (
        swap("bottom", "top"),
        "the facet of 'bottom' at (2, 1.5, 4) mm faces up; expected down",
    ),
    "one facet of the top named bottom": (
        one_cell(lambda name: "bottom" if name == "top" else name),
        "the facet of 'bottom' at (2, 1.5, 4) mm faces up; expected down",
    ),
    "a side named top": (
        GOOD.regroup(lambda name, _: "top" if name == "x_max" else name),
        "the facet of 'top' at (12, 1.5, 1) mm faces towards higher x; expected up",
    ),
    "x_min and x_max exchanged": (
        swap("x_min", "x_max"),
        "the facet of 'x_min' at (12, 1.5, 1) mm faces towards higher x; expected towards lower x",
    ),
    "y_min and y_max exchanged": (
        swap("y_min", "y_max"),
        "the facet of 'y_min' at (2, 6, 1) mm faces towards higher y; expected towards lower y",
    ),
    "a facet of y_max named x_max": (
        only("y_max", "x_max", 9),
        "the facet of 'x_max' at (10, 6, 1) mm faces towards higher y; expected towards higher x",
    ),
    "the top named sides": (
        only("top", "sides", 9),
        "the facet of 'sides' at (10, 1.5, 4) mm faces up; expected a side",
    ),
    "turned by a quarter": (
        turned(90),
        "its sides x_min, x_max, y_min, y_max are turned by 90 degrees about z; expected a stack that lies along x",
    ),
    "turned a little": (turned(10), "are turned by 10 degrees about z; expected a stack that lies along x and y"),
    "standing on its side": (
        GOOD.with_points(lambda points: points[:, [2, 0, 1]]),
        "the facet of 'bottom' at (0, 2, 1.5) mm faces towards lower x; expected down",
    ),
    "layers from the top down": (
        swap("layer_1", "layer_2"),
        "the facet of 'bottom' at (2, 1.5, 0) mm is one of 'layer_2'; expected 'layer_1', layers from the bottom up",
    ),
    "a cell in the layer of its neighbour": (
        stack(3).regroup(lambda name, at: "layer_3" if name == "layer_2" and at[0] < 3 else name),
        "at (2, 1.5, 2) mm 'layer_3' lies on 'layer_1'; expected layers on each other, from the bottom up",
    ),
    "a bottom cell in the layer above": (
        GOOD.regroup(lambda name, at: {"layer_1": "layer_2", "bottom": None}.get(name, name) if at[0] < 3 else name),
        "at (4, 1.5, 1) mm 'layer_2' lies beside 'layer_1'; expected layers on each other, from the bottom up",
    ),
    "middle layers exchanged": (
        in_order(1, 3, 2),
        "the facet of 'top' at (2, 1.5, 6) mm is one of 'layer_2'; expected 'layer_3', layers from the bottom up",
    ),
    "a bent mirror plane": (
        move(0, 1e-3, lambda points: (points[:, 0] == 0) & (points[:, 2] > 3e-3)),
        "the facet of 'x_min' at (0.5, 1.5, 3) mm is 1 mm off x = 0 mm, where the stack ends; expected a plane there",
    ),
    "no facets of the top": (
        GOOD.regroup(lambda name, _: None if name == "top" else name),
        "no facets named 'top'; expected them",
    ),
    "a facet without a group": (
        only("top", None, 9),
        "the facet at (10, 1.5, 4) mm has no tag; expected bottom, top or a side",
    ),
    "a facet in two groups": (
        GOOD.twice("top", "bottom", 3),
        "the facet at (2, 1.5, 4) mm is in 'bottom' and in 'top'; expected it in one physical surface",
    ),
    "a cell in two layers": (
        GOOD.twice("layer_1", "layer_2", 5),
        "the cell at (2, 1.5, 1) mm is in 'layer_1' and in 'layer_2'; expected it in one physical volume",
    ),
    "a cell twice": (
        GOOD.twice("layer_1", "layer_1", 5),
        "the cell at (2, 1.5, 1) mm is in 'layer_1' twice; expected it once",
    ),
    "a facet inside": (
        replace(GOOD, elements=[*GOOD.elements, (3, gmsh_files.NUMBERS["top"], GOOD.elements[0][2][4:])]),
        "the facet of 'top' at (2, 1.5, 2) mm lies between two cells; expected a face on the outside",
    ),
    "a facet of no cell": (
        replace(GOOD, elements=[*GOOD.elements, (3, gmsh_files.NUMBERS["top"], GOOD.elements[0][2][1:5])]),
        "is the face of no cell; expected a face on the outside",
    ),
    "a third layer that the scene does not have": (
        stack(3),
        "is in 'layer_3'; expected physical volume layer_1 to layer_2",
    ),
    "an empty layer": (
        GOOD.regroup(lambda name, _: "layer_1" if name == "layer_2" else name),
        "the physical volume 'layer_2' is empty; expected cells in it",
    ),
    "millimetres": (
        GOOD.with_points(lambda points: 1e3 * points),
        "it measures 1.2e+04 mm along x; expected 0.01 mm to 10 m (a mesh's lengths are metres)",
    ),
    "inches": (
        GOOD.with_points(lambda points: points / 0.0254),
        "layer 1 is 78.74 mm thick on average; expected stack.thickness = 2 mm (a mesh's lengths are metres)",
    ),
    "kilometres": (
        GOOD.with_points(lambda points: 1e-3 * points),
        "it measures 0.006 mm along y; expected 0.01 mm to 10 m",
    ),
    "no number": (
        move(2, np.nan, lambda points: np.arange(len(points)) == 4),
        "node 5 is at (0, 0, nan); expected finite coordinates",
    ),
    "infinite": (
        move(0, np.inf, lambda points: np.arange(len(points)) == 4),
        "node 5 is at (inf, 0, 0.002); expected finite coordinates",
    ),
    "an inverted cell": (
        replace(GOOD, elements=[(5, 1, GOOD.elements[0][2][4:] + GOOD.elements[0][2][:4]), *GOOD.elements[1:]]),
        "cell 0 at (2, 1.5, 1) mm is inverted; expected hexahedra with positive volume",
    ),
    "a gap between layers": (
        apart(1e-3),
        "layer 1 meets layer 2 at a mean height of 2 mm, but that one begins at 3 mm; expected layers that touch",
    ),
    "layers in each other": (
        apart(-0.5e-3),
        "layer 1 meets layer 2 at a mean height of 2 mm, but that one begins at 1.5 mm; expected layers that touch",
    ),
    "a node that is not there": (
        replace(GOOD, tags=GOOD.tags[:-1], points=GOOD.points[:-1]),
        "an element has the node 36, which is not in the file; expected those of section $Nodes",
    ),
    "an element with node 0": (
        replace(GOOD, elements=[*GOOD.elements, (5, 1, [0, *GOOD.elements[0][2][1:]])]),
        "an element has the node 0, which is not in the file",
    ),
    "an element with a negative node": (
        replace(GOOD, elements=[*GOOD.elements, (5, 1, [-3, *GOOD.elements[0][2][1:]])]),
        "an element has the node -3, which is not in the file",
    ),
    "negative numbers of nodes": (renumbered(lambda tag: -tag), "has a node with the number -36; expected 1 or more"),
    "a number of two nodes": (renumbered(lambda tag: max(tag, 2)), "has 2 nodes with the number 2; expected one"),
    "a number beyond all memory": (
        renumbered(lambda tag: tag if tag < 36 else 10**15),
        "an element has the node 36, which is not in the file",
    ),
    "tetrahedra": (
        replace(GOOD, elements=[*GOOD.elements, (4, 1, [1, 2, 3, 4])]),
        "has tetrahedra (gmsh's type 4); expected linear hexahedra, and quads as their facets",
    ),
    "hexahedra of order 2": (
        replace(GOOD, elements=[*GOOD.elements, (17, 1, [*range(1, 21)])]),
        "has elements of order 2 (gmsh's type 17); expected linear hexahedra",
    ),
    "a type that gmsh does not have": (
        replace(GOOD, elements=[*GOOD.elements, (999, 1, [1, 2, 3, 4])]),
        "has elements (gmsh's type 999); expected linear hexahedra",
    ),
    "no cells": (
        GOOD.regroup(lambda name, _: None if name.startswith("layer") else name),
        "has no hexahedra; expected the physical volumes layer_1, ...",
    ),
    "no facets": (
        GOOD.regroup(lambda name, _: name if name.startswith("layer") else None),
        "has no quads; expected physical surfaces bottom, top",
    ),
    "two names for a group": (
        replace(GOOD, names=[*GOOD.names, (2, gmsh_files.NUMBERS["top"], "bottom")]),
        "physical number 5 is named 'top' and 'bottom'; expected one name",
    ),
    "no names": (replace(GOOD, names=[]), "no physical volume 'layer_1'; expected one for each layer, found none"),
    "an unknown name": (
        replace(GOOD, names=[(d, n, "lid" if name == "top" else name) for d, n, name in GOOD.names]),
        "the facet at (2, 1.5, 4) mm is in 'lid'; expected physical surface bottom, top, x_min",
    ),
    "a facet whose group has no name": (
        replace(GOOD, names=[name for name in GOOD.names if name[2] != "top"]),
        "the facet at (2, 1.5, 4) mm is in no group with a name; expected physical surface bottom, top, x_min",
    ),
}
BYTES = {
    "empty": ("", "is empty; expected a gmsh file of format 4.1 or 2.2"),
    "blank": ("\n \n", "is empty; expected a gmsh file of format 4.1 or 2.2"),
    "rubbish": (bytes(range(256)) * 9, "does not begin with $MeshFormat; expected a gmsh file of format 4.1 or 2.2"),
    "another format": ("solid cube\nfacet normal 0 0 1\n", "does not begin with $MeshFormat"),
    "format 1": ("$NOD\n1\n1 0 0 0\n$ENDNOD\n", "format 1: save as 4.1 or 2.2"),
    "format 3": (text_22(GOOD, "3 0 8"), "format 3: save as 4.1 or 2.2"),
    "format 4.0": (text_41(GOOD, line="4.0 0 8"), "format 4.0: save as 4.1 or 2.2"),
    "format 5": (text_41(GOOD, line="5.2 0 8"), "format 5.2: save as 4.1 or 2.2"),
    "no format": (text_22(GOOD, "msh"), "$MeshFormat says 'msh'; expected three numbers such as '4.1 0 8'"),
    "called binary": (text_41(GOOD, line="4.1 1 8"), "have the order of bytes of another machine; expected text"),
    "cut in nodes": (
        TEXT[: TEXT.index("$Nodes") + 60],
        "section $Nodes has no end; expected $EndNodes: the file is cut",
    ),
    "cut before elements": (TEXT[: TEXT.index("$Elements")], "has no section $Elements; expected nodes and elements"),
    "cut in a head": (
        TEXT[: TEXT.index("$Elements") + 5],
        "b'$Elem' stands after section $Nodes; expected the next section",
    ),
    "only a format": ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "has no section $Nodes; expected nodes and elements"),
    "fewer nodes than announced": (
        TEXT.replace("$Nodes\n36", "$Nodes\n37"),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "more nodes than announced": (
        TEXT.replace("$Nodes\n36", "$Nodes\n35"),
        "section $Nodes holds more than it announces; expected its end",
    ),
    "more nodes than any file has": (
        TEXT.replace("$Nodes\n36", "$Nodes\n999999999999"),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "no number of nodes": (
        TEXT.replace("$Nodes\n36", "$Nodes\n" + "9" * 5000),
        "section $Nodes begins with",
    ),
    "fewer elements than announced": (
        re.sub(r"\$Elements\n\d+", "$Elements\n99", TEXT),
        "elements to come; expected as many as it announces",
    ),
    "more elements than announced": (
        re.sub(r"\$Elements\n\d+", "$Elements\n10", TEXT),
        "section $Elements holds more than it announces; expected its end",
    ),
    "words for coordinates": (
        TEXT.replace("0.006", "six", 1),
        "section $Nodes holds what is no number; expected numbers",
    ),
    "decimal commas": (TEXT.replace("0.006", "0,006"), "section $Nodes holds what is no number; expected numbers"),
    "half a node": (
        TEXT.replace("\n7 ", "\n6.5 ", 1),
        "section $Nodes holds 6.5; expected a whole number",
    ),
    "two sections of nodes": (
        TEXT + TEXT[TEXT.index("$Nodes") : TEXT.index("$Elements")],
        "has two sections $Nodes; expected one",
    ),
    "fewer names than announced": (
        TEXT.replace("$PhysicalNames\n11", "$PhysicalNames\n12"),
        "$PhysicalNames announces '12' names and holds 11; expected the same",
    ),
    "a name without quotes": (
        TEXT.replace('"top"', "top"),
        "$PhysicalNames says '2 5 top'; expected a line such as '2 1 \"bottom\"'",
    ),
    "an entity in two layers": (
        text_41(GOOD, [("layer_1", "layer_2")]),
        "the cell at (2, 1.5, 1) mm is in 'layer_1' and in 'layer_2'; expected it in one physical volume",
    ),
    "an entity in two groups": (
        text_41(GOOD, [("top", "sides")]),
        "the facet at (2, 1.5, 4) mm is in 'sides' and in 'top'; expected it in one physical surface",
    ),
    "an entity that is not there": (
        LATER.replace("2 4 3 6\n", "2 44 3 6\n"),
        "has elements of an entity 44 of dimension 2; expected those of section $Entities",
    ),
    "4.1 without entities": (
        LATER[: LATER.index("$Entities")] + LATER[LATER.index("$Nodes") :],
        "the cell at (2, 1.5, 1) mm is in no group with a name; expected physical volume layer_1 to layer_2",
    ),
    "4.1 with fewer nodes in all": (
        LATER.replace("$Nodes\n1 36", "$Nodes\n1 35"),
        "section $Nodes announces 35 nodes and holds 36; expected the same",
    ),
    "4.1 with a block too many": (LATER.replace("$Nodes\n1 36", "$Nodes\n2 36"), "section $Nodes ends early"),
    "4.1 with a negative block": (
        LATER.replace("3 1 0 36", "3 1 0 -36"),
        "section $Nodes announces -36 entries; expected none or more",
    ),
    "binary, cut off": (
        binary(LATER)[:-200],
        "section $Elements has no end; expected $EndElements: the file is cut off",
    ),
    "binary, some bytes less": (
        re.sub(rb"(?s).{8}\n\$EndNodes", b"\n$EndNodes", binary(LATER)),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "binary, some bytes more": (
        binary(TEXT).replace(b"$EndNodes", b"1234567$EndNodes"),
        "section $Nodes holds more than it announces; expected its end",
    ),
}


def write(folder, content, layers=2, sides=None):
    """A scene with a mesh file, on rank 0; the same on all."""
    path = folder / "mesh.msh"
    if COMM.rank == 0:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    COMM.barrier()
    table = {"duration": "1 s", "stack": {"layers": layers, "mesh": str(path)}}
    if sides is not None:
        table["stack"]["sides"] = sides
    return Scene.from_table(table)


def line_of(scene):
    with pytest.raises(SceneError) as caught:
        build_mesh(scene, COMM)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(("mesh.msh: ", "mesh: "))
    return line


@pytest.mark.parametrize("text", [text_22, text_41], ids=["2.2", "4.1"])
@pytest.mark.parametrize("name", GROUPS)
def test_a_defect_of_the_mesh_is_one_line(name, text, folder):
    mesh, expected = GROUPS[name]
    layers = 3 if name in ("middle layers exchanged", "a cell in the layer of its neighbour") else 2
    if text is text_41 and any(number < 0 for _, _, nodes in mesh.elements for number in nodes):
        pytest.skip("a size is not negative")
    assert expected in line_of(write(folder, text(mesh), layers))


@pytest.mark.parametrize("name", BYTES)
def test_a_defect_of_the_file_is_one_line(name, folder):
    content, expected = BYTES[name]
    assert expected in line_of(write(folder, content))


def test_layers_with_nodes_of_their_own_lie_in_order_too(folder):
    """Neither shared faces nor the outermost layers tell that the two in between are exchanged."""
    names = {"layer_2": "layer_3", "layer_3": "layer_2"}
    mesh = stack(4, own_nodes=True).regroup(lambda name, _: names.get(name, name))
    expected = "'layer_3' is at a height of 3 mm, 'layer_2' at 5 mm; expected layers from the bottom up"
    assert expected in line_of(write(folder, text_22(mesh), layers=4))


ALL_WAYS = pytest.mark.parametrize(
    "content",
    [TEXT.encode(), LATER.encode(), binary(TEXT), binary(LATER)],
    ids=["2.2", "4.1", "binary 2.2", "binary 4.1"],
)


@ALL_WAYS
def test_a_file_cut_anywhere_is_one_line(content, folder):
    for cut in range(0, len(content) - 12, 97):
        line_of(write(folder, content[:cut]))


@ALL_WAYS
def test_a_file_with_bytes_replaced_is_read_or_one_line(content, folder):
    """Whatever stands in a file, it ends as a mesh or as a SceneError."""
    random = np.random.default_rng(7)
    refused = 0
    for _ in range(60):
        data = bytearray(content)
        for place in random.integers(len(data), size=3):
            data[place] = random.choice(np.frombuffer(b"0123456789-. $e\x00\xff\n", np.uint8))
        try:
            stack_of(write(folder, bytes(data)))
        except SceneError:
            refused += 1
    assert refused > 20


def same(one, two):
    return np.array_equal(one.points, two.points) and np.array_equal(one.cells, two.cells)


@pytest.mark.parametrize("content", [LATER, binary(TEXT), binary(LATER), TEXT.replace("\n", "\r\n"), "\ufeff" + TEXT])
def test_all_ways_to_write_a_mesh_give_the_same(content, folder):
    write(folder, TEXT)
    expected = read_gmsh(folder / "mesh.msh", 2)
    COMM.barrier()
    build_mesh(write(folder, content), COMM)
    found = read_gmsh(folder / "mesh.msh", 2)
    assert same(found, expected)
    assert np.array_equal(found.layer, expected.layer)
    assert np.array_equal(found.face_tags, expected.face_tags)


def corners(path):
    """Corners of all cells of a file, in an order that depends on nothing but their places."""
    read = read_gmsh(path, 2)
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
    mesh = read_gmsh(path, layers)
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


PROGRAM = {
    "a defect of the mesh": (text_22(GROUPS["bottom and top exchanged"][0]), GROUPS["bottom and top exchanged"][1]),
    "a format": (text_41(GOOD, line="4.0 0 8"), "mesh.msh: format 4.0: save as 4.1 or 2.2"),
    "a file cut off": (binary(LATER)[:700], "the file is cut off"),
}


@pytest.mark.serial
@pytest.mark.parametrize("name", PROGRAM)
def test_the_program_says_it_in_one_line_and_writes_nothing(name, folder):
    content, expected = PROGRAM[name]
    write(folder, content)
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    ended = call("run", "scene.toml", "--out", "out", folder=folder)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert expected in line
    assert not (folder / "out").exists()
