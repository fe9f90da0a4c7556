"""Meshes in files of Abaqus and VTK: the stack of the same gmsh file, and what is wrong with a file in one line."""

import re

import gmsh_files
import meshio
import numpy as np
import pytest
from gmsh_files import COMM, GOOD, GROUPS, line_of, text_41
from program import ROOT, script

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mesh.hexahedra import TAGS
from ncf_fenicsx.mesh.stack_file import read_stack

SIDES = [name for name in GROUPS if name in TAGS]
FORMATS = ["inp", "nodes.inp", "vtu", "vtk"]


def deck(mesh, by_nodes=False):
    """An Abaqus deck: sides as sets of facets, or of nodes; nodes and layers in two blocks, with comments between."""
    rows = [f"{tag}, {x!r}, {y!r}, {z!r}" for tag, (x, y, z) in zip(mesh.tags, mesh.points.tolist(), strict=True)]
    lines = ["*HEADING", "a stack", "*Node, nset=All", *rows[:5], "** a comment", *rows[5:9], "*NODE", *rows[9:]]
    sets = {}
    for number, (kind, group, nodes) in enumerate(mesh.elements, 1):
        name = GROUPS[group - 1]
        if kind == 5:
            lines += [f"*Element, type=C3D8R, elset={name}", ", ".join(map(str, [number, *nodes[:4]])) + ","]
            lines += ["** the rest", ", ".join(map(str, nodes[4:]))]
        elif by_nodes:
            sets.setdefault(name, set()).update(nodes)
        else:
            lines += ["*ELEMENT, TYPE=S4, ELSET=PART_" + name, ", ".join(map(str, [number, *nodes]))]
            sets.setdefault(name, set()).add(number)
    for name, members in sets.items():
        keyword = "NSET" if by_nodes else "ELSET"
        lines += [f"*{keyword}, {keyword}={name.upper()}", *(f"{member}," for member in sorted(members))]
    return "\n".join([*lines, "*ELSET, ELSET=EVERYTHING, GENERATE", "1, 4", "*MATERIAL, NAME=M", "*ELASTIC", "1., 0."])


def vtk(mesh, path):
    """A VTK file by meshio."""
    kinds = {"hexahedron": 5, "quad": 3}
    chosen = {shape: [one for one in mesh.elements if one[0] == kind] for shape, kind in kinds.items()}
    cells = [(shape, np.array([nodes for *_, nodes in rows]) - 1) for shape, rows in chosen.items()]
    names = {shape: [GROUPS[group - 1] for _, group, _ in rows] for shape, rows in chosen.items()}
    layer = [np.array([int(name[6:]) for name in names["hexahedron"]]), np.zeros(len(names["quad"]), int)]
    side = [np.zeros(len(layer[0]), int), np.array([TAGS[name] for name in names["quad"]])]
    meshio.write(path, meshio.Mesh(mesh.points, cells, cell_data={"layer": layer, "side": side}))


def written(folder, mesh, form):
    """Path of a file of a mesh, written on rank 0."""
    path = folder / f"mesh.{form}"
    if COMM.rank == 0:
        if form == "msh":
            path.write_text(text_41(mesh))
        elif form.endswith("inp"):
            path.write_text(deck(mesh, form.startswith("nodes")))
        else:
            vtk(mesh, path)
    COMM.barrier()
    return path


def sorted_stack(stack):
    """Centres, layers and face tags of the cells of a stack, in an order that does not depend on the file."""
    centres = stack.points[stack.cells].mean(axis=1)
    order = np.lexsort(np.round(centres, 9).T)
    return centres[order], stack.layer[order], stack.face_tags[order]


@pytest.mark.serial
@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("own_nodes", [False, True])
def test_the_stack_is_that_of_the_gmsh_file(folder, form, own_nodes):
    mesh = gmsh_files.stack(own_nodes=own_nodes)
    expected = sorted_stack(read_stack(written(folder, mesh, "msh"), 2))
    for found, right in zip(sorted_stack(read_stack(written(folder, mesh, form), 2)), expected, strict=True):
        assert found == pytest.approx(right)


@pytest.mark.two_ranks
def test_three_formats_give_one_history(folder, table):
    histories = []
    for form in ("msh", "inp", "vtu"):
        scene = Scene.from_table(table | {"stack": {"layers": 2, "mesh": str(written(folder, GOOD, form))}})
        histories.append(run(scene, folder / form).history)
    assert histories[0][-1]["tool_force"] > 0
    for other in histories[1:]:
        for row, expected in zip(other, histories[0], strict=True):
            for name in ("time", "tool_force", "vf_max"):
                assert row[name] == pytest.approx(expected[name], rel=1e-9, abs=1e-13)


@pytest.mark.serial
def test_a_deck_that_gmsh_writes_is_the_stack_of_its_own_file(folder):
    module = script(ROOT / "meshes" / "stack.py")
    for name in ("stack.msh", "stack.inp"):
        small = ["--divisions", "3", "2", "2", "--layers", "2", str(folder / name)]
        module.build_from(module.options().parse_args(small))
        module.write_mesh(folder / name)
    first, second = (sorted_stack(read_stack(folder / name, 2)) for name in ("stack.msh", "stack.inp"))
    for found, right in zip(second, first, strict=True):
        assert found == pytest.approx(right)


TEXT = deck(GOOD)
DEFECTS = {
    "no deck": ("1 2 3\n", "does not begin with a keyword; expected an Abaqus deck"),
    "empty": ("", "does not begin with a keyword; expected an Abaqus deck"),
    "an included file": ("*INCLUDE, INPUT=nodes.inp\n" + TEXT, "has *INCLUDE; expected a flat deck"),
    "no number": (
        TEXT.replace("*ELSET, ELSET=TOP\n", "*ELSET, ELSET=TOP\n1x2,\n"),
        "*ELSET holds '1x2'; expected",
    ),
    "two coordinates": (TEXT.replace("*NODE\n", "*NODE\n99, 0., 0.\n"), "*NODE holds the row '99, 0., 0.'; expected"),
    "a node of no place": (TEXT.replace("*NODE\n", "*NODE\n99, 0., nan, 0.\n"), "node 99 is at (0, nan, 0); expected"),
    "a node twice": (TEXT.replace("*NODE\n", "*NODE\n1, 0., 0., 0.\n"), "has 2 nodes with the number 1; expected one"),
    "a node that is missing": (TEXT.replace("1, 0.0, 0.0, 0.0\n", ""), "an element has the node 1, which is not in"),
    "tetrahedra": (TEXT + "\n*ELEMENT, TYPE=C3D4\n900, 1, 2, 3, 4", "has elements of type 'C3D4'; expected C3D8"),
    "a cell cut off": (TEXT + "\n*ELEMENT, TYPE=C3D8\n900, 1, 2", "*ELEMENT of type C3D8 holds 3 numbers; expected 9"),
    "a layer that is missing": (
        TEXT.replace("layer_2", "ply_2"),
        "no element set 'layer_2'; expected one for",
    ),
    "a cell in no layer": (
        TEXT.replace("layer_2", "ply_2", 1),
        "is in no group with a name; expected",
    ),
    "a cell in two layers": (
        TEXT + "\n*ELSET, ELSET=LAYER_2\n1",
        "is in 'layer_1' and in 'layer_2'; expected it in one element set",
    ),
    "a side that is missing": (TEXT.replace("ELSET=TOP", "ELSET=LID"), "no facets named 'top'"),
    "sides exchanged": (
        TEXT.replace("ELSET=TOP", "ELSET=A").replace("ELSET=BOTTOM", "ELSET=TOP").replace("ELSET=A", "ELSET=BOTTOM"),
        "'bottom'",
    ),
}


@pytest.mark.serial
@pytest.mark.parametrize("name", DEFECTS)
def test_what_is_wrong_with_a_deck_is_named_in_one_line(folder, name):
    text, complaint = DEFECTS[name]
    (folder / "mesh.inp").write_text(text)
    line = line_of(Scene.from_table({"duration": "1 s", "stack": {"layers": 2, "mesh": str(folder / "mesh.inp")}}))
    assert complaint in line


def altered(change):
    """Change of a VTK file's mesh, as meshio reads it."""

    def write(path):
        vtk(GOOD, path)
        mesh = meshio.read(path)
        change(mesh)
        meshio.write(path, mesh)

    return write


def _set(mesh, name, block, place, value):
    mesh.cell_data[name][block] = mesh.cell_data[name][block].astype(type(value))
    mesh.cell_data[name][block][place] = value


VTK_DEFECTS = {
    "no VTK": (lambda path: path.write_text("solid"), "cannot be read: .*; expected a VTK file"),
    "cut off": (lambda path: (vtk(GOOD, path), path.write_bytes(path.read_bytes()[:900])), "cannot be read: "),
    "no layers": (
        altered(lambda mesh: mesh.cell_data.pop("layer")),
        "has no cell data 'layer'; expected a",
    ),
    "half a layer": (altered(lambda mesh: _set(mesh, "layer", 0, 2, 1.5)), "'layer' are not whole numbers"),
    "a layer too many": (altered(lambda mesh: _set(mesh, "layer", 0, 2, 7)), "is in 'layer_7'; expected"),
    "an unknown side": (altered(lambda mesh: _set(mesh, "side", 1, 2, 9)), "the facet at .* is in no group"),
    "a point that is missing": (altered(lambda mesh: mesh.cells[0].data.__setitem__((2, 3), 500)), "has the point 500"),
    "no place": (altered(lambda mesh: mesh.points.__setitem__((3, 1), np.nan)), "node 4 is at .*; expected finite"),
}


@pytest.mark.serial
@pytest.mark.parametrize("name", VTK_DEFECTS)
def test_what_is_wrong_with_a_vtk_file_is_named_in_one_line(folder, name):
    write, complaint = VTK_DEFECTS[name]
    write(folder / "mesh.vtu")
    line = line_of(Scene.from_table({"duration": "1 s", "stack": {"layers": 2, "mesh": str(folder / "mesh.vtu")}}))
    assert re.search(complaint, line)
