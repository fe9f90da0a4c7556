"""Stacks of hexahedra as plain arrays: extrusion, faces, checks, columns. No DOLFINx here.

Vertices of a cell are numbered as in DOLFINx, x fastest, then y, then z: (0,0,0), (1,0,0), (0,1,0), (1,1,0), (0,0,1)...
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.grid_lines import places

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FACES = np.array([[0, 1, 2, 3], [0, 1, 4, 5], [0, 2, 4, 6], [1, 3, 5, 7], [2, 3, 6, 7], [4, 5, 6, 7]])
NO_TAG = 0
TAGS = {"bottom": 1, "top": 2, "x_min": 3, "x_max": 4, "y_min": 5, "y_max": 6, "sides": 7}
"""Numbers of the tags of outside facets."""
STEEP = 0.3
"""Facets between layers are flatter than this: the height of their unit normal is above it."""


def lower_tag(layer: Any) -> Any:
    """Tag of the upper face of a layer (0 at the bottom), the lower of the two faces that meet there."""
    return 100 + 2 * layer


def upper_tag(layer: Any) -> Any:
    """Tag of the lower face of the next layer, the upper of the two faces that meet there."""
    return 101 + 2 * layer


@dataclass(frozen=True)
class Hexahedra:
    """A stack of layers.

    Attributes:
        points: coordinates in m, shape (points, 3).
        cells: vertices, shape (cells, 8).
        layer: number of each cell's layer, 0 at the bottom, shape (cells,).
        face_tags: tag of each cell's six faces, ``NO_TAG`` inside a layer, shape (cells, 6).
    """

    points: Floats
    cells: Integers
    layer: Integers
    face_tags: Integers

    @property
    def face_vertices(self) -> Integers:
        """Sorted vertices of every face, shape (6 cells, 4)."""
        return np.sort(self.cells[:, FACES].reshape(-1, 4), axis=1)

    @property
    def face_centres(self) -> Floats:
        """Centres of every face in m, shape (6 cells, 3)."""
        return self.points[self.cells[:, FACES].reshape(-1, 4)].mean(axis=1)


def graded(divisions: int, length: float, focus: float, grading: float) -> Floats:
    """Coordinates of ``divisions`` intervals on [0, length], refined towards ``focus``.

    On each side of the focus the distance from it is D ((1 - g) s + g s^2), with s uniform on [0, 1].
    """
    focus = min(max(focus, 0.0), length)
    before = round(divisions * focus / length)
    if divisions > 1 and 0 < focus < length:
        before = min(max(before, 1), divisions - 1)
    start = focus if before else 0.0
    left = start - start * _spread(before, grading)[::-1]
    anchor = start if before < divisions else length
    right = anchor + (length - anchor) * _spread(divisions - before, grading)
    return np.concatenate([left[:-1], right]) if before else right


def _spread(divisions: int, grading: float) -> Floats:
    s = np.linspace(0.0, 1.0, divisions + 1)
    return (1 - grading) * s + grading * s**2


def extrude(grids: list[list[Floats]], heights: list[Floats]) -> Hexahedra:
    """Layers of hexahedra over grids, each layer with nodes of its own.

    Args:
        grids: coordinates x and y in m of each layer, from the bottom up.
        heights: coordinates in m through each layer.
    """
    layers = enumerate(zip(grids, heights, strict=True))
    parts = [_extrude_layer(x, y, z, number, len(heights)) for number, ((x, y), z) in layers]
    offsets = np.cumsum([0] + [len(part.points) for part in parts[:-1]])
    return Hexahedra(
        points=np.concatenate([part.points for part in parts]),
        cells=np.concatenate([part.cells + offset for part, offset in zip(parts, offsets, strict=True)]),
        layer=np.concatenate([part.layer for part in parts]),
        face_tags=np.concatenate([part.face_tags for part in parts]),
    )


def _extrude_layer(x: Floats, y: Floats, z: Floats, number: int, layers: int) -> Hexahedra:
    shape = (len(z), len(y), len(x))
    Z, Y, X = np.meshgrid(z, y, x, indexing="ij")
    node = np.arange(X.size).reshape(shape)
    corners = [
        node[k : k + shape[0] - 1, j : j + shape[1] - 1, i : i + shape[2] - 1] for k, j, i in np.ndindex(2, 2, 2)
    ]
    tags = np.zeros((shape[0] - 1, shape[1] - 1, shape[2] - 1, 6), dtype=np.int64)
    tags[:, :, 0, 2], tags[:, :, -1, 3] = TAGS["x_min"], TAGS["x_max"]
    tags[:, 0, :, 1], tags[:, -1, :, 4] = TAGS["y_min"], TAGS["y_max"]
    tags[0, :, :, 0] = TAGS["bottom"] if number == 0 else NO_TAG
    tags[-1, :, :, 5] = TAGS["top"] if number == layers - 1 else NO_TAG
    cells = np.stack([corner.ravel() for corner in corners], axis=1)
    points = np.stack([X.ravel(), Y.ravel(), Z.ravel()], axis=1)
    return Hexahedra(points, cells, np.full(len(cells), number), tags.reshape(-1, 6))


def split_layers(stack: Hexahedra, sublaminate: Integers) -> Hexahedra:
    """The stack with nodes that belong to one sublaminate of bonded layers each.

    Args:
        stack: layers, those of a sublaminate sharing their nodes.
        sublaminate: number of each layer's sublaminate, shape (layers,).
    """
    key = sublaminate[stack.layer][:, None] * len(stack.points) + stack.cells
    unique, cells = np.unique(key, return_inverse=True)
    points = stack.points[unique % len(stack.points)]
    return Hexahedra(points, cells.reshape(-1, 8), stack.layer, stack.face_tags)


def bond_layers(stack: Hexahedra) -> Hexahedra:
    """The stack with coincident nodes made one."""
    number = coincidence(stack.points, stack.points)
    _, first, new = np.unique(number, return_index=True, return_inverse=True)
    return Hexahedra(stack.points[first], new[stack.cells], stack.layer, stack.face_tags)


def coincidence(points: Floats, extent: Floats) -> Integers:
    """A number for every point, the same for points closer than 1e-7 of the extent of a cloud, shape (points,)."""
    tolerance = 1e-7 * float(np.ptp(extent, axis=0).max())
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    number = np.arange(len(points))
    for low, high in pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))] if len(pairs) else ():
        number[high] = min(number[high], number[low])
    return number


def mark_interfaces(stack: Hexahedra, sublaminate: Integers) -> Hexahedra:
    """The stack with tagged faces where a layer lies on the next; within one sublaminate, those of the lower one alone.

    Raises:
        SceneError: an outside face has no tag, or bonded layers do not share their nodes.
    """
    group, count = alike(stack.face_vertices)
    cell, face = np.nonzero((count == 1).reshape(-1, 6) & (stack.face_tags == NO_TAG))
    upwards, layer = unit(outward_areas(stack, cell, face))[:, 2], stack.layer[cell]
    other = layer + np.where(upwards > 0, 1, -1)
    lonely = np.flatnonzero((np.abs(upwards) < STEEP) | (other < 0) | (other >= len(sublaminate)))
    centres = stack.face_centres.reshape(-1, 6, 3)[cell, face]
    if len(lonely):
        raise SceneError(
            f"mesh: the facet at {point_in_words(centres[lonely[0]])} has no tag; expected bottom, top or a side"
        )
    torn = np.flatnonzero(sublaminate[layer] == sublaminate[other])
    if len(torn):
        number = min(layer[torn[0]], other[torn[0]]) + 1
        raise SceneError(f"mesh: layers {number} and {number + 1} are bonded; expected facets that match")
    tags = stack.face_tags.copy()
    tags[cell, face] = np.where(upwards > 0, lower_tag(layer), upper_tag(other))
    layers, highest = np.repeat(stack.layer, 6), np.zeros(group.max() + 1, dtype=np.int64)
    np.maximum.at(highest, group, layers)
    shared = (layers < highest[group]).reshape(-1, 6)
    tags[shared] = lower_tag(layers.reshape(-1, 6)[shared])
    return Hexahedra(stack.points, stack.cells, stack.layer, tags)


def outward_areas(stack: Hexahedra, cell: Integers, face: Integers) -> Floats:
    """Outward normals of faces, as long as the area is large, in m2, shape (faces, 3)."""
    quads = stack.points[stack.cells[cell[:, None], FACES[face]]]
    normal = np.cross(quads[:, 3] - quads[:, 0], quads[:, 2] - quads[:, 1]) / 2
    outwards = quads.mean(axis=1) - stack.points[stack.cells[cell]].mean(axis=1)
    areas: Floats = np.sign(np.einsum("ij,ij->i", normal, outwards))[:, None] * normal
    return areas


def unit(vectors: Floats) -> Floats:
    """Vectors of length one in the same directions, shape as given."""
    units: Floats = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return units


def corner_volumes(stack: Hexahedra) -> Floats:
    """Jacobian at each corner of each cell in m3, shape (cells, 8); equal to the volume where edges are parallel."""
    corners = stack.points[stack.cells]
    volumes = np.empty(corners.shape[:2])
    for corner in range(8):
        along = [corners[:, corner ^ bit] - corners[:, corner] for bit in (1, 2, 4)]
        sign = (-1.0) ** bin(corner).count("1")
        volumes[:, corner] = sign * np.einsum("ij,ij->i", np.cross(along[0], along[1]), along[2])
    return volumes


def is_degenerate(smallest: Any, extent: Floats) -> Any:
    """Whether hexahedra have no volume to speak of.

    Args:
        smallest: Jacobian of their corners in m3, the smallest of each.
        extent: along the axes in m, shape (..., 3).
    """
    return smallest <= 1e-6 * extent.prod(axis=-1) + 1e-18 * extent.max(axis=-1) ** 3


def check_cells(stack: Hexahedra) -> None:
    """Raise a SceneError that names the first inverted or degenerate cell, by the Jacobian at its corners."""
    corners = stack.points[stack.cells]
    smallest = corner_volumes(stack).min(axis=1)
    bad = np.flatnonzero(is_degenerate(smallest, np.ptp(corners, axis=1)))
    if len(bad):
        what = "inverted" if smallest[bad[0]] < 0 else "degenerate"
        where = point_in_words(corners[bad[0]].mean(axis=0))
        raise SceneError(f"mesh: cell {bad[0]} at {where} is {what}; expected hexahedra with positive volume")


def between(stack: Hexahedra, vertices: Integers) -> Integers:
    """A number for every node of every cell, the same for one that cells share; shape (cells, nodes).

    Args:
        stack: the cells.
        vertices: of a cell, in the middle of which each node stands, shape (nodes, 4).
    """
    if len(vertices) == stack.cells.shape[1]:
        return stack.cells
    around = np.sort(stack.cells[:, vertices], axis=2)
    _, number = np.unique(around.reshape(-1, 4), axis=0, return_inverse=True)
    return number.reshape(len(stack.cells), -1)


def columns(stack: Hexahedra, parts: int) -> Integers:
    """Kind of each cell: whole columns of cells over each other, about equally many cells in each part."""
    centres = stack.points[stack.cells].mean(axis=1)
    column = places(centres[:, :2], float(np.ptp(stack.points, axis=0).max()))
    members = np.bincount(column)
    positions = np.stack([np.bincount(column, centres[:, axis]) / members for axis in (0, 1)], axis=1)
    part = np.zeros(len(centres), dtype=np.int64)
    _bisect(positions[column], column, np.arange(len(centres)), 0, parts, part)
    return part


def _bisect(positions: Floats, column: Integers, members: Integers, first: int, parts: int, part: Integers) -> None:
    if parts == 1 or not len(members):
        part[members] = first
        return
    axis = int(np.argmax(np.ptp(positions[members], axis=0)))
    order = members[np.lexsort((column[members], positions[members, axis]))]
    cut = len(order) * (parts // 2) // parts
    while 0 < cut < len(order) and column[order[cut]] == column[order[cut - 1]]:
        cut += 1
    _bisect(positions, column, order[:cut], first, parts // 2, part)
    _bisect(positions, column, order[cut:], first + parts // 2, parts - parts // 2, part)


def alike(rows: Integers) -> tuple[Integers, Integers]:
    """Group of equal rows that each row belongs to, and how many that group has; shapes (rows,)."""
    order = np.lexsort(rows.T)
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = (np.diff(rows[order], axis=0) != 0).any(axis=1)
    group = np.empty(len(rows), dtype=np.int64)
    group[order] = np.cumsum(begins) - 1
    return group, np.bincount(group)[group]


def point_in_words(point: Floats) -> str:
    """A point (m) in words."""
    return "(" + ", ".join(f"{round(1e3 * value, 9) + 0.0:.4g}" for value in point) + ") mm"
