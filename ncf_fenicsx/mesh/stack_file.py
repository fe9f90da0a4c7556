"""A mesh file as a stack of hexahedra: names of its groups say which cells are which layer, which facets which side."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.hexahedra import FACES, NO_TAG, TAGS, Floats, Hexahedra, Integers, alike, point_in_words
from ncf_fenicsx.mesh.inp_file import read_inp
from ncf_fenicsx.mesh.mesh_file import HEXAHEDRON, QUAD, BrokenFileError, MeshFile
from ncf_fenicsx.mesh.msh_file import read_msh
from ncf_fenicsx.mesh.vtk_file import read_vtk

VTK_TO_TENSOR = [0, 1, 3, 2, 4, 5, 7, 6]
NO_NAME = "no group with a name"
READERS = {".inp": read_inp, ".vtk": read_vtk, ".vtu": read_vtk}
"""By the ending of a file's name; gmsh's for all others."""


def read_stack(path: Path, layers: int) -> Hexahedra:
    """Stack in a file of gmsh (``.msh``), Abaqus (``.inp``) or VTK (``.vtk``, ``.vtu``), lengths in metres.

    The groups ``layer_1`` (bottom) to ``layer_N`` hold the cells; ``bottom``, ``top`` and ``x_min``, ``x_max``,
    ``y_min``, ``y_max`` (or ``sides``) hold the outside facets. Where they lie is not looked at.

    Raises:
        SceneError: unreadable, elements that are no hexahedra, a name that is missing or unknown, a cell in no layer or
            in two, a facet in two groups or inside the stack.
    """
    read = READERS.get(path.suffix.lower(), read_msh)
    try:
        return _stack(read(path), layers)
    except BrokenFileError as error:
        raise SceneError(f"{path.name}: {error}") from error


def _stack(file: MeshFile, layers: int) -> Hexahedra:
    cells = file.elements[HEXAHEDRON]
    if not len(cells):
        raise BrokenFileError(f"has no hexahedra; expected the {file.volume}s layer_1, ...")
    _check_names(file, layers)
    _check_alone(file, HEXAHEDRON)
    cells = cells[:, VTK_TO_TENSOR]
    layer = _layers(file, layers)
    face_tags = _face_tags(file, cells)
    used, compact = np.unique(cells, return_inverse=True)
    return Hexahedra(file.points[used], compact.reshape(-1, 8), layer, face_tags)


def _group_names(file: MeshFile, kind: int) -> list[str]:
    """Name of the group of each quad or hexahedron."""
    dimension = {QUAD: 2, HEXAHEDRON: 3}[kind]
    numbers, place = np.unique(file.groups[kind], return_inverse=True)
    names = [file.names.get((dimension, int(number)), NO_NAME) for number in numbers]
    return [names[number] for number in place]


def _centres(file: MeshFile, kind: int) -> Floats:
    centres: Floats = file.points[file.elements[kind]].mean(axis=1)
    return centres


def _check_names(file: MeshFile, layers: int) -> None:
    volumes = sorted(name for (dimension, _), name in file.names.items() if dimension == 3)
    for name in _layer_names(layers):
        if name not in volumes:
            found = ", ".join(volumes) or "none"
            raise BrokenFileError(f"no {file.volume} {name!r}; expected one for each layer, found {found}")


def _layer_names(layers: int) -> list[str]:
    return [f"layer_{number + 1}" for number in range(layers)]


def _check_alone(file: MeshFile, kind: int) -> None:
    """Refuse a cell that is there twice, or a facet in two groups; a facet may be named twice."""
    nodes = np.sort(file.elements[kind], axis=1)
    order = np.lexsort(nodes.T)
    twice = order[1:][(np.diff(nodes[order], axis=0) == 0).all(axis=1)]
    before = order[:-1][(np.diff(nodes[order], axis=0) == 0).all(axis=1)]
    if kind == QUAD:
        apart = file.groups[kind][twice] != file.groups[kind][before]
        twice, before = twice[apart], before[apart]
    if not len(twice):
        return
    names = _group_names(file, kind)
    found = sorted({names[twice[0]], names[before[0]]})
    where = point_in_words(_centres(file, kind)[twice[0]])
    what, expected = ("facet", f"one {file.surface}") if kind == QUAD else ("cell", f"one {file.volume}")
    if len(found) == 1:
        raise BrokenFileError(f"the {what} at {where} is in {found[0]!r} twice; expected it once")
    raise BrokenFileError(f"the {what} at {where} is in {found[0]!r} and in {found[1]!r}; expected it in {expected}")


def _layers(file: MeshFile, layers: int) -> Integers:
    names = _group_names(file, HEXAHEDRON)
    place = {name: number for number, name in enumerate(_layer_names(layers))}
    layer = np.array([place.get(name, -1) for name in names])
    unknown = np.flatnonzero(layer < 0)
    if len(unknown):
        where = point_in_words(_centres(file, HEXAHEDRON)[unknown[0]])
        expected = "layer_1" if layers == 1 else f"layer_1 to layer_{layers}"
        name = _quoted(names[unknown[0]])
        raise BrokenFileError(f"the cell at {where} is in {name}; expected {file.volume} {expected}")
    empty = np.setdiff1d(np.arange(layers), layer)
    if len(empty):
        raise BrokenFileError(f"the {file.volume} 'layer_{empty[0] + 1}' is empty; expected cells in it")
    return layer


def _quoted(name: str) -> str:
    return name if name == NO_NAME else repr(name)


def _face_tags(file: MeshFile, cells: Integers) -> Integers:
    names = _group_names(file, QUAD)
    if not names:
        raise BrokenFileError(f"has no quads; expected {file.surface}s {', '.join(TAGS)}")
    wrong = next((number for number, name in enumerate(names) if name not in TAGS), None)
    if wrong is not None:
        where, name = point_in_words(_centres(file, QUAD)[wrong]), _quoted(names[wrong])
        raise BrokenFileError(f"the facet at {where} is in {name}; expected {file.surface} {', '.join(TAGS)}")
    _check_alone(file, QUAD)
    quads = np.sort(file.elements[QUAD], axis=1)
    faces = np.sort(cells[:, FACES].reshape(-1, 4), axis=1)
    group, _ = alike(np.concatenate([quads, faces]))
    of_quads, of_faces = np.split(group, [len(quads)])
    sharing = np.bincount(of_faces, minlength=int(group.max()) + 1)[of_quads]
    for number in np.flatnonzero(sharing != 1)[:1]:
        where = point_in_words(_centres(file, QUAD)[number])
        is_what = "is the face of no cell" if sharing[number] == 0 else "lies between two cells"
        raise BrokenFileError(f"the facet of {names[number]!r} at {where} {is_what}; expected a face on the outside")
    tag_of_group = np.full(int(group.max()) + 1, NO_TAG)
    tag_of_group[of_quads] = [TAGS[name] for name in names]
    return tag_of_group[of_faces].reshape(-1, 6)
