"""A gmsh file as a stack of hexahedra: its physical names say which cells are which layer, which facets which side."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.hexahedra import FACES, NO_TAG, TAGS, Hexahedra, Integers, point_in_words

VTK_TO_TENSOR = [0, 1, 3, 2, 4, 5, 7, 6]


def read_gmsh(path: Path, layers: int) -> Hexahedra:
    """Stack in a gmsh file, lengths in metres.

    Physical volumes ``layer_1`` (bottom) to ``layer_N`` hold the cells; physical surfaces ``bottom``, ``top`` and
    ``x_min``, ``x_max``, ``y_min``, ``y_max`` (or ``sides``) hold the outside facets.

    Raises:
        SceneError: unreadable, cells that are no hexahedra, a cell without a layer, a missing or unknown name.
    """
    file = _read(path)
    shapes = {block.type for block in file.cells} - {"vertex", "line", "quad", "hexahedron"}
    cells = np.asarray(file.cells_dict.get("hexahedron", np.zeros((0, 8))), dtype=np.int64)
    if shapes or not len(cells):
        raise SceneError(f"{path.name}: has {', '.join(sorted(shapes)) or 'no cells'}; expected linear hexahedra only")
    cells = cells[:, VTK_TO_TENSOR]
    layer = _layers(path, file, layers, file.points[cells].mean(axis=1))
    face_tags = _face_tags(path, file, cells)
    used, compact = np.unique(cells, return_inverse=True)
    return Hexahedra(np.asarray(file.points[used], dtype=float), compact.reshape(-1, 8), layer, face_tags)


def _read(path: Path) -> Any:
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return meshio.read(path, file_format="gmsh")
    except (Exception, SystemExit) as error:  # meshio exits or raises anything on a malformed file
        raise SceneError(f"{path.name}: expected a gmsh mesh, but it cannot be read as one ({error})") from error


def _physical(path: Path, file: Any, shape: str) -> tuple[Integers, dict[int, str]]:
    """Physical number of each cell of a shape, and the names of those numbers."""
    dimension = {"quad": 2, "hexahedron": 3}[shape]
    names = {int(data[0]): name for name, data in file.field_data.items() if int(data[1]) == dimension}
    numbers = file.cell_data_dict.get("gmsh:physical", {}).get(shape)
    if numbers is None:
        raise SceneError(f"{path.name}: its {shape} cells have no physical names; expected layer_1, bottom, top, ...")
    return np.asarray(numbers, dtype=np.int64), names


def _layers(path: Path, file: Any, layers: int, centres: np.ndarray) -> Integers:
    numbers, names = _physical(path, file, "hexahedron")
    expected = [f"layer_{k + 1}" for k in range(layers)]
    known = {number: expected.index(name) for number, name in names.items() if name in expected}
    for name in expected:
        if name not in names.values():
            found = ", ".join(sorted(names.values())) or "none"
            raise SceneError(f"{path.name}: no physical volume {name!r}; expected one for each layer, found {found}")
    unknown = np.flatnonzero(~np.isin(numbers, list(known)))
    if len(unknown):
        name = names.get(int(numbers[unknown[0]]), "none")
        raise SceneError(
            f"{path.name}: the cell at {point_in_words(centres[unknown[0]])} is in {name!r}; "
            "expected a physical volume layer_1, ..."
        )
    return np.array([known[int(number)] for number in numbers])


def _face_tags(path: Path, file: Any, cells: Integers) -> Integers:
    numbers, names = _physical(path, file, "quad")
    surfaces = {int(number): names.get(int(number), "none") for number in np.unique(numbers)}
    for name in surfaces.values():
        if name not in TAGS:
            raise SceneError(f"{path.name}: physical surface {name!r}; expected one of {', '.join(TAGS)}")
    quads = np.sort(file.cells_dict["quad"].astype(np.int64), axis=1)
    faces = np.sort(cells[:, FACES].reshape(-1, 4), axis=1)
    _, group = np.unique(np.concatenate([quads, faces]), axis=0, return_inverse=True)
    tag_of_group = np.full(int(group.max()) + 1, NO_TAG)
    tag_of_group[group.ravel()[: len(quads)]] = [TAGS[surfaces[int(number)]] for number in numbers]
    return tag_of_group[group.ravel()[len(quads) :]].reshape(-1, 6)
