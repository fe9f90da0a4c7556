"""What a gmsh file holds, in format 4.1 or 2.2, as text or binary: nodes, hexahedra, facets, names of groups.

Every number is accounted for. meshio takes the last node for one that the file lacks, and one of many groups.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ncf_fenicsx.mesh.mesh_file import (
    HEXAHEDRON,
    QUAD,
    Floats,
    Integers,
    MeshFile,
    check_nodes,
    contents,
    fail,
    rows_of,
)
from ncf_fenicsx.mesh.msh_sections import Numbers, layout, sections

SIZES = {15: 1, 1: 2, QUAD: 4, HEXAHEDRON: 8}
"""Nodes of the elements that may be in a file, by gmsh's number of the type: points, lines, quads, hexahedra."""
OTHERS = {2: "triangles", 4: "tetrahedra", 6: "prisms", 7: "pyramids"}
OTHERS |= dict.fromkeys((8, 9, 10, 11, 12, 13, 14, 16, 17, 18, 19), "elements of order 2")
NODE = np.dtype([("tag", "<i4"), ("place", "<f8", 3)])
NAME = re.compile(r'\s*(\d)\s+(\d{1,15})\s+"([^"]*)"\s*')
FIRST_LOOK = 64
"""Rows of elements that are looked at first to find how many are alike."""

Block = tuple[int, Integers, Integers]
"""Type of elements, tags of their nodes of shape (elements, nodes), and their physical numbers, 0 without a group."""


def read_msh(path: Path) -> MeshFile:
    """Contents of a gmsh file.

    Raises:
        BrokenFileError: it cannot be read, or does not hold together.
    """
    bodies = sections(contents(path))
    version, binary, size = layout(bodies["MeshFormat"])
    numbers = {name: Numbers(name, body, binary, size) for name, body in bodies.items()}
    for name in ("Nodes", "Elements"):
        if name not in bodies:
            fail(f"has no section ${name}; expected nodes and elements")
    if version == "4.1":
        tags, points = _nodes_41(numbers["Nodes"])
        blocks = list(_blocks_41(numbers["Elements"], _groups_of_entities(numbers.get("Entities"))))
    else:
        tags, points = _nodes_22(numbers["Nodes"])
        blocks = list(_blocks_22(numbers["Elements"]))
    for name in ("Nodes", "Elements"):
        numbers[name].end()
    check_nodes(tags, points)
    elements, groups = {}, {}
    for kind in (QUAD, HEXAHEDRON):
        nodes = [rows for code, rows, _ in blocks if code == kind]
        elements[kind] = rows_of(
            np.concatenate([np.zeros((0, SIZES[kind]), dtype=np.int64), *nodes]), tags, "section $Nodes"
        )
        physical = [numbers for code, _, numbers in blocks if code == kind]
        groups[kind] = np.concatenate([np.zeros(0, dtype=np.int64), *physical])
    names = _names(bodies.get("PhysicalNames", b""))
    return MeshFile(points, elements, groups, names, "physical volume", "physical surface")


def _nodes_41(numbers: Numbers) -> tuple[Integers, Floats]:
    blocks, total, _, _ = numbers.sizes(4)
    tags: list[Integers] = [np.zeros(0, dtype=np.int64)]
    points: list[Floats] = [np.zeros((0, 3))]
    for _ in range(blocks):
        dimension, _, parametric = numbers.whole(3)
        if not 0 <= dimension <= 3:
            fail(f"section $Nodes holds a block of dimension {dimension}; expected 0 to 3")
        count, width = numbers.size(), 3 + (dimension if parametric else 0)
        tags.append(numbers.sizes(count))
        points.append(numbers.take(count * width, "<f8").reshape(count, width)[:, :3])
    found = sum(len(part) for part in tags)
    if found != total:
        fail(f"section $Nodes announces {total} nodes and holds {found}; expected the same")
    return np.concatenate(tags), np.concatenate(points)


def _nodes_22(numbers: Numbers) -> tuple[Integers, Floats]:
    count = numbers.first_line()
    if numbers.binary:
        nodes = numbers.take(count, NODE)
        return nodes["tag"].astype(np.int64), nodes["place"]
    rows = numbers.take(4 * count, float).reshape(count, 4)
    return numbers.exact(rows[:, 0]), rows[:, 1:]


def _groups_of_entities(numbers: Numbers | None) -> dict[tuple[int, int], Integers]:
    """Physical numbers of each entity of format 4.1, by its dimension and number."""
    groups: dict[tuple[int, int], Integers] = {}
    if numbers is None:
        return groups
    for dimension, count in enumerate(numbers.sizes(4)):
        for _ in range(count):
            entity = int(numbers.whole(1)[0])
            numbers.take(3 if dimension == 0 else 6, "<f8")
            groups[dimension, entity] = np.abs(numbers.whole(numbers.size()))  # negative where it is turned round
            if dimension:
                numbers.whole(numbers.size())
    return groups


def _blocks_41(numbers: Numbers, groups: dict[tuple[int, int], Integers]) -> Iterator[Block]:
    count, total, _, _ = numbers.sizes(4)
    found = 0
    for _ in range(count):
        dimension, entity, kind = (int(value) for value in numbers.whole(3))
        width, elements = 1 + _size_of(kind), numbers.size()
        rows = numbers.sizes(elements * width).reshape(elements, width)[:, 1:]
        found += elements
        if groups and (dimension, entity) not in groups:
            fail(f"has elements of an entity {entity} of dimension {dimension}; expected those of section $Entities")
        physical = groups.get((dimension, entity), np.zeros(0, dtype=np.int64))
        for number in physical if len(physical) else (0,):
            yield kind, rows, np.full(elements, number)
    if found != total:
        fail(f"section $Elements announces {total} elements and holds {found}; expected the same")


def _blocks_22(numbers: Numbers) -> Iterator[Block]:
    total = numbers.first_line()
    found = 0
    rows_of = _binary_rows_22 if numbers.binary else _text_rows_22
    for kind, tags, rows in rows_of(numbers, total):
        found += len(rows)
        physical = np.abs(rows[:, 0]) if tags else np.zeros(len(rows), dtype=np.int64)
        yield kind, rows[:, tags:], physical
    if found != total:
        fail(f"section $Elements announces {total} elements and holds {found}; expected the same")


def _binary_rows_22(numbers: Numbers, total: int) -> Iterator[tuple[int, int, Integers]]:
    """Type, number of tags, and rows of tags and nodes, of elements that follow each other."""
    while total > 0:
        kind, count, tags = (int(value) for value in numbers.whole(3))
        if count < 1 or tags < 0:
            fail(f"section $Elements announces {count} elements with {tags} tags; expected one or more")
        width = 1 + tags + _size_of(kind)
        yield kind, tags, numbers.whole(count * width).reshape(count, width)[:, 1:]
        total -= count


def _text_rows_22(numbers: Numbers, total: int) -> Iterator[tuple[int, int, Integers]]:
    """The same of text, where each row has its own type and number of tags: as many as are alike at a time."""
    values, at, look = numbers.rest(), 0, FIRST_LOOK
    while total > 0:
        if at + 3 > len(values):
            fail(f"section $Elements ends with {total} elements to come; expected as many as it announces")
        kind, tags = int(values[at + 1]), int(values[at + 2])
        width = 3 + tags + _size_of(kind)
        rows = values[at : at + min(look, total) * width]
        if tags < 0 or len(rows) < width:
            fail(f"section $Elements ends with {total} elements to come; expected as many as it announces")
        rows = rows[: len(rows) // width * width].reshape(-1, width)
        alike = (rows[:, 1] == kind) & (rows[:, 2] == tags)
        count = len(rows) if alike.all() else int(np.argmin(alike))
        yield kind, tags, rows[:count, 3:]
        at, total, look = at + count * width, total - count, 2 * look if alike.all() else FIRST_LOOK
    if at < len(values):
        fail("section $Elements holds more than it announces; expected its end")


def _size_of(kind: int) -> int:
    """Number of nodes of an element of a type."""
    if kind not in SIZES:
        name = OTHERS.get(kind, "elements")
        fail(f"has {name} (gmsh's type {kind}); expected linear hexahedra, and quads as their facets")
    return SIZES[kind]


def _names(body: bytes) -> dict[tuple[int, int], str]:
    count, *lines = body.decode("utf-8", errors="replace").strip().splitlines() or ["0"]
    found: dict[tuple[int, int], str] = {}
    for line in lines:
        match = NAME.fullmatch(line)
        if match is None:
            fail(f"$PhysicalNames says {line.strip()[:40]!r}; expected a line such as '2 1 \"bottom\"'")
        key = int(match[1]), int(match[2])
        if found.setdefault(key, match[3]) != match[3]:
            fail(f"physical number {key[1]} is named {found[key]!r} and {match[3]!r}; expected one name")
    if count.strip() != str(len(lines)):
        fail(f"$PhysicalNames announces {count.strip()[:20]!r} names and holds {len(lines)}; expected the same")
    return found
