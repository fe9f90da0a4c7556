"""Contents of a VTK file, ``.vtk`` or ``.vtu``, where cell data have the part of names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np

from ncf_fenicsx.mesh.hexahedra import TAGS
from ncf_fenicsx.mesh.mesh_file import HEXAHEDRON, QUAD, Integers, MeshFile, check_nodes, fail

PASSED_OVER = {"vertex", "line"}
SHAPES = {"quad": (QUAD, 4, "side"), "hexahedron": (HEXAHEDRON, 8, "layer")}


def read_vtk(path: Path) -> MeshFile:
    """Contents of a file with the cell data ``layer`` of hexahedra, 1 at the bottom, and ``side`` of quads, as in TAGS.

    Raises:
        BrokenFileError: it cannot be read, or does not hold together.
    """
    try:
        mesh = {".vtk": meshio.vtk.read, ".vtu": meshio.vtu.read}[path.suffix.lower()](path)
    except Exception as error:  # of many kinds, each some defect of the file
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        fail(f"cannot be read: {reason}; expected a VTK file of an unstructured grid")
    points = np.asarray(mesh.points, dtype=float)
    check_nodes(np.arange(1, len(points) + 1), points)
    for block in mesh.cells:
        if block.type not in SHAPES and block.type not in PASSED_OVER:
            fail(f"has cells of type {block.type}; expected linear hexahedra, and quads as their facets")
    elements, groups = {}, {}
    for shape, (kind, width, name) in SHAPES.items():
        cells, groups[kind] = _of_shape(mesh, shape, width, name)
        if len(cells) and not 0 <= cells.min() <= cells.max() < len(points):
            fail(f"a {shape} has the point {cells.max()}; expected 0 to {len(points) - 1}")
        elements[kind] = cells
    names = {(2, number): name for name, number in TAGS.items()}
    names |= {(3, number): f"layer_{number}" for number in map(int, np.unique(groups[HEXAHEDRON])) if number > 0}
    return MeshFile(points, elements, groups, names, "cell data 'layer' of", "cell data 'side' of")


def _of_shape(mesh: Any, shape: str, width: int, name: str) -> tuple[Integers, Integers]:
    """Points of all cells of a shape, and the number of each."""
    cells: list[Any] = [np.zeros((0, width), dtype=np.int64)]
    numbers: list[Any] = [np.zeros(0, dtype=np.int64)]
    for place, block in enumerate(mesh.cells):
        if block.type != shape:
            continue
        if name not in mesh.cell_data:
            fail(f"has no cell data {name!r}; expected a whole number for each {shape}")
        values = np.asarray(mesh.cell_data[name][place], dtype=float)
        if values.ndim != 1 or (values != np.floor(values)).any():
            fail(f"cell data {name!r} are not whole numbers; expected one for each {shape}")
        cells.append(block.data)
        numbers.append(values.astype(np.int64))
    return np.concatenate(cells).astype(np.int64), np.concatenate(numbers)
