"""Groups of mesh files that lie or face elsewhere than their names say, and good files, bent and turned over."""

from dataclasses import replace

import gmsh_files
import numpy as np
import pytest
from gmsh_files import GOOD, line_of, stack, text_22, text_41, write

pytestmark = pytest.mark.two_ranks

FREE = {"x_min": "fixed", "x_max": "free", "y_min": "free", "y_max": "free"}


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


@pytest.mark.parametrize("text", [text_22, text_41], ids=["2.2", "4.1"])
@pytest.mark.parametrize("name", GROUPS)
def test_a_defect_of_the_mesh_is_one_line(name, text, folder):
    mesh, expected = GROUPS[name]
    layers = 3 if name in ("middle layers exchanged", "a cell in the layer of its neighbour") else 2
    if text is text_41 and any(number < 0 for _, _, nodes in mesh.elements for number in nodes):
        pytest.skip("a size is not negative")
    assert expected in line_of(write(folder, text(mesh), layers))


def test_layers_with_nodes_of_their_own_lie_in_order_too(folder):
    """Neither shared faces nor the outermost layers tell that the two in between are exchanged."""
    names = {"layer_2": "layer_3", "layer_3": "layer_2"}
    mesh = stack(4, own_nodes=True).regroup(lambda name, _: names.get(name, name))
    expected = "'layer_3' is at a height of 3 mm, 'layer_2' at 5 mm; expected layers from the bottom up"
    assert expected in line_of(write(folder, text_22(mesh), layers=4))
