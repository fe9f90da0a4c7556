"""What a mesh file holds, whatever its format: nodes, hexahedra, facets, groups and their names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

QUAD, HEXAHEDRON = 3, 5
"""Gmsh's numbers of the types of elements that are kept."""


@dataclass(frozen=True)
class MeshFile:
    """Contents of a file.

    Attributes:
        points: coordinates in the file's unit, shape (nodes, 3).
        elements: rows of ``points`` of each quad and hexahedron, by type, shape (elements, 4 or 8), vertices in the
            order of VTK, gmsh and Abaqus alike.
        groups: numbers of the groups of those, 0 without one; an element of several groups is there once for each.
        names: of groups, by dimension and number.
        volume: what the format calls a group of cells.
        surface: what it calls a group of facets.
    """

    points: Floats
    elements: dict[int, Integers]
    groups: dict[int, Integers]
    names: dict[tuple[int, int], str]
    volume: str
    surface: str


class BrokenFileError(Exception):
    """What is wrong with the contents of a file, in words."""


def fail(words: str) -> NoReturn:
    """Raise a BrokenFileError."""
    raise BrokenFileError(words)


def contents(path: Path) -> bytes:
    """Bytes of a file of text, without a mark of its encoding.

    Raises:
        BrokenFileError: it cannot be read.
    """
    try:
        return path.read_bytes().removeprefix(b"\xef\xbb\xbf")
    except OSError as error:
        return fail(f"{error.strerror}; expected a mesh file")


def check_nodes(tags: Integers, points: Floats) -> None:
    """Refuse numbers of nodes below 1 or twice, and coordinates that are not finite."""
    if len(tags) and tags.min() < 1:
        fail(f"has a node with the number {tags.min()}; expected 1 or more")
    unique, count = np.unique(tags, return_counts=True)
    if len(unique) < len(tags):
        fail(f"has {count.max()} nodes with the number {unique[np.argmax(count)]}; expected one")
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(wrong):
        place = ", ".join(f"{value:g}" for value in points[wrong[0]])
        fail(f"node {tags[wrong[0]]} is at ({place}); expected finite coordinates")


def rows_of(nodes: Integers, tags: Integers, where: str) -> Integers:
    """Where the nodes of elements stand among all nodes, which ``where`` in the file says."""
    order = np.argsort(tags)
    place = np.minimum(np.searchsorted(tags[order], nodes), len(tags) - 1)
    if not len(tags) or not np.array_equal(tags[order][place], nodes):
        missing = np.setdiff1d(nodes, tags)
        if len(missing):
            fail(f"an element has the node {missing[0]}, which is not in the file; expected those of {where}")
    return order[place]
