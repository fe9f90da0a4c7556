"""Contents of an Abaqus input deck: nodes, elements, and the sets of them that name layers and sides.

meshio is not used here: it forgets nodes of all blocks but the last, rows behind a comment, and sets in several blocks.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from meshio.abaqus._abaqus import abaqus_to_meshio_type

from ncf_fenicsx.mesh.hexahedra import TAGS
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

WIDTHS = {"vertex": 1, "line": 2, "quad": 4, "hexahedron": 8}
"""Nodes of the elements that may be in a deck, by meshio's name of their shape."""
KINDS = {"quad": QUAD, "hexahedron": HEXAHEDRON}
LAYER = re.compile(r"layer_\d{1,9}")
ELSEWHERE = {"INCLUDE", "INSTANCE", "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}
"""Keywords that make or move nodes and elements that are not written out."""
VTK_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


def read_inp(path: Path) -> MeshFile:
    """Contents of a flat deck.

    Element sets ``LAYER_1`` and so on, in capitals or not, hold the cells. Each side is an element set of quads, or a
    set of nodes: then its facets are those outside with all of their nodes in it. Other sets are passed over.

    Raises:
        BrokenFileError: it does not hold together.
    """
    deck = _Deck()
    for keyword, options, rows in _blocks(contents(path).decode("utf-8", errors="replace").splitlines()):
        if keyword in ELSEWHERE:
            fail(f"has *{keyword}; expected a flat deck, with all nodes and elements written out")
        if keyword in ("NODE", "ELEMENT", "NSET", "ELSET"):
            getattr(deck, keyword.lower())(options, rows)
    return deck.contents()


def _blocks(lines: list[str]) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keyword, its options, and its rows, without comments."""
    kept = [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("**")]
    starts = [number for number, line in enumerate(kept) if line.startswith("*")]
    if not starts or starts[0] > 0:
        fail("does not begin with a keyword; expected an Abaqus deck with *NODE and *ELEMENT")
    for start, end in zip(starts, [*starts[1:], len(kept)], strict=True):
        head, rows = kept[start], kept[start + 1 : end]
        while head.endswith(",") and rows:
            head += rows.pop(0)
        keyword, *words = head[1:].split(",")
        pairs = (word.partition("=") for word in words if word.strip())
        yield (
            " ".join(keyword.upper().split()),
            {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs},
            rows,
        )


def _numbers(keyword: str, rows: list[str]) -> Floats:
    words = " ".join(rows).replace(",", " ").split()
    try:
        return np.array(words, dtype=float)
    except ValueError:
        wrong = next(word for word in words if not re.fullmatch(r"[-+]?[\d.]+([eE][-+]?\d+)?", word))
        return fail(f"*{keyword} holds {wrong[:20]!r}; expected numbers")


def _whole(keyword: str, rows: list[str]) -> Integers:
    values = _numbers(keyword, rows)
    wrong = np.flatnonzero(values != np.floor(values))
    if len(wrong):
        fail(f"*{keyword} holds {values[wrong[0]]:g}; expected a whole number")
    return values.astype(np.int64)


class _Deck:
    """What has been read so far; sets by their names in small letters."""

    def __init__(self) -> None:
        self.tags: list[Integers] = [np.zeros(0, dtype=np.int64)]
        self.points: list[Floats] = [np.zeros((0, 3))]
        self.cells: dict[int, list[Integers]] = {kind: [np.zeros((0, width + 1), np.int64)] for kind, width in _kept()}
        self.node_sets: dict[str, list[Integers]] = defaultdict(list)
        self.element_sets: dict[str, list[Integers]] = defaultdict(list)

    def node(self, options: dict[str, str], rows: list[str]) -> None:
        for row in rows:
            if len(row.split(",")) != 4:
                fail(f"*NODE holds the row {row[:40]!r}; expected a number and three coordinates")
        values = _numbers("NODE", rows).reshape(-1, 4)
        self.tags.append(_whole("NODE", [row.partition(",")[0] for row in rows]))
        self.points.append(values[:, 1:])
        if "NSET" in options:
            self.node_sets[options["NSET"].lower()].append(self.tags[-1])

    def element(self, options: dict[str, str], rows: list[str]) -> None:
        kind = options.get("TYPE", "").upper()
        shape = abaqus_to_meshio_type.get(kind, kind)
        if shape not in WIDTHS:
            fail(f"has elements of type {kind!r}; expected C3D8, and elements of four nodes as their facets")
        values, width = _whole("ELEMENT", rows), WIDTHS[shape] + 1
        if len(values) % width:
            fail(f"*ELEMENT of type {kind} holds {len(values)} numbers; expected {width} for each")
        if shape in KINDS:
            self.cells[KINDS[shape]].append(values.reshape(-1, width))
        if "ELSET" in options:
            self.element_sets[options["ELSET"].lower()].append(values.reshape(-1, width)[:, 0])

    def nset(self, options: dict[str, str], rows: list[str]) -> None:
        _add(self.node_sets, "NSET", options, rows)

    def elset(self, options: dict[str, str], rows: list[str]) -> None:
        _add(self.element_sets, "ELSET", options, rows)

    def contents(self) -> MeshFile:
        tags, points = np.concatenate(self.tags), np.concatenate(self.points)
        check_nodes(tags, points)
        elements, groups, names = {}, {}, {}
        for kind, dimension in ((QUAD, 2), (HEXAHEDRON, 3)):
            cells = np.concatenate(self.cells[kind])
            found = [name for name in self.element_sets if (LAYER.fullmatch(name) if dimension == 3 else name in TAGS)]
            rows: list[Integers] = [np.zeros(0, np.int64)]
            numbers: list[Integers] = [np.zeros(0, np.int64)]
            for number, name in enumerate(found, 1):
                names[dimension, number] = name
                rows.append(np.flatnonzero(np.isin(cells[:, 0], np.concatenate(self.element_sets[name]))))
                numbers.append(np.full(len(rows[-1]), number))
            if dimension == 3:
                rows.append(np.setdiff1d(np.arange(len(cells)), np.concatenate(rows)))
                numbers.append(np.zeros(len(rows[-1]), np.int64))
            chosen = np.concatenate(rows)
            elements[kind] = rows_of(cells[chosen, 1:], tags, "*NODE")
            groups[kind] = np.concatenate(numbers)
        file = MeshFile(points, elements, groups, names, "element set", "element or node set")
        return self._with_facets_of_nodes(file, tags)

    def _with_facets_of_nodes(self, file: MeshFile, tags: Integers) -> MeshFile:
        """The same with facets of the sides that are sets of nodes alone."""
        faces = np.unique(file.elements[HEXAHEDRON], axis=0)[:, VTK_FACES].reshape(-1, 4)
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        outside = faces[first[count == 1]]
        elements, groups, names = [file.elements[QUAD]], [file.groups[QUAD]], dict(file.names)
        for name in [name for name in self.node_sets if name in TAGS and name not in file.names.values()]:
            members = rows_of(np.concatenate(self.node_sets[name]), tags, "*NODE")
            elements.append(outside[np.isin(outside, members).all(axis=1)])
            number = 1 + sum(dimension == 2 for dimension, _ in names)
            names[2, number] = name
            groups.append(np.full(len(elements[-1]), number))
        quads = {QUAD: np.concatenate(elements), HEXAHEDRON: file.elements[HEXAHEDRON]}
        both = {QUAD: np.concatenate(groups), HEXAHEDRON: file.groups[HEXAHEDRON]}
        return MeshFile(file.points, quads, both, names, file.volume, file.surface)


def _kept() -> list[tuple[int, int]]:
    return [(kind, WIDTHS[shape]) for shape, kind in KINDS.items()]


def _add(sets: dict[str, list[Integers]], keyword: str, options: dict[str, str], rows: list[str]) -> None:
    """Add to a set; its rows are numbers, ranges with GENERATE, or names of other sets."""
    name = options.get(keyword, "").lower()
    others = [word.strip().lower() for row in rows for word in row.split(",") if re.match(r"\s*[A-Za-z_]", word)]
    if others:
        sets[name] += [numbers for other in others for numbers in sets.get(other, [])]
        return
    values = _whole(keyword, rows)
    if "GENERATE" in options:
        ranges = [_whole(keyword, [row]) for row in rows]
        if any(len(one) not in (2, 3) for one in ranges):
            fail(f"*{keyword}, GENERATE of {name.upper()} holds {rows[0][:30]!r}; expected a first, a last and a step")
        values = np.concatenate([np.arange(one[0], one[1] + 1, *one[2:]) for one in ranges])
    sets[name].append(values)
