"""Write the mesh of each case as gmsh 4.1 and as an Abaqus deck: ``docker/run python3 demos/crosscheck/meshes.py``.

Layers have nodes of their own. Groups of cells are ``layer_1`` (bottom) and so on, groups of facets ``bottom``,
``top``, ``x_min`` and so on; in the deck they are element sets, and sets of nodes too. Lengths are in metres.
"""

import sys
from contextlib import chdir
from pathlib import Path

import gmsh
import numpy as np

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh.hexahedra import FACES, TAGS
from ncf_fenicsx.mesh.stack_file import VTK_TO_TENSOR
from ncf_fenicsx.mesh.stack_mesh import stack_of

HERE = Path(__file__).parent
ROUND = [0, 1, 3, 2]
"""Vertices of a face one after the other around it."""
QUAD, HEXAHEDRON = 3, 5


def groups(stack):
    """Name, dimension, gmsh's type and vertices of the elements of each group."""
    for layer in range(int(stack.layer.max()) + 1):
        yield f"layer_{layer + 1}", 3, HEXAHEDRON, stack.cells[stack.layer == layer][:, VTK_TO_TENSOR]
    faces = stack.cells[:, FACES][:, :, ROUND]
    for name, tag in TAGS.items():
        if (stack.face_tags == tag).any():
            yield name, 2, QUAD, faces[stack.face_tags == tag]


def write(case, folder):
    """Write ``mesh.msh`` and ``mesh.inp`` of a case into a folder."""
    stack = stack_of(Scene.read(HERE / case / "scene.toml"))
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    for number, (name, dimension, kind, nodes) in enumerate(groups(stack), 1):
        gmsh.model.addDiscreteEntity(dimension, number)
        if number == 1:
            gmsh.model.mesh.addNodes(3, 1, np.arange(1, len(stack.points) + 1), stack.points.ravel())
        gmsh.model.mesh.addElementsByType(number, kind, [], 1 + nodes.ravel())
        gmsh.model.addPhysicalGroup(dimension, [number], name=name)
    with chdir(folder):  # gmsh writes the name that it is given into the deck
        for ending in ("msh", "inp"):
            gmsh.write(f"mesh.{ending}")
    gmsh.finalize()


if __name__ == "__main__":
    for chosen in sys.argv[1:] or sorted(file.parent.name for file in HERE.glob("*/scene.toml")):
        write(chosen, HERE / chosen)
