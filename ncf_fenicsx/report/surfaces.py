"""Layers, tools and mould of a run as arrays to draw: who meets whom, and how all moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.report import tool_places
from ncf_fenicsx.report.reading import Results, read_fields

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
"""Corners of the faces of a hexahedron in VTK's order, anticlockwise from outside."""
MARGIN = 0.08
"""How far a surface without an end is drawn past the stack, over the stack's length."""


@dataclass(frozen=True)
class Layers:
    """Mesh and fields of a run at some steps.

    Attributes:
        points: undeformed, in m, shape (nodes, 3).
        cells: nodes of the hexahedra in VTK's order, shape (cells, 8).
        layer: of each cell, 1 at the bottom.
        times: of the steps in s.
        nodes: fields at nodes in SI by name, shape (steps, nodes); ``displacement_x`` and so on are among them.
        by_cell: fields of cells in SI by name, shape (steps, cells).
    """

    points: Floats
    cells: Integers
    layer: Integers
    times: Floats
    nodes: dict[str, NDArray[Any]]
    by_cell: dict[str, NDArray[Any]]

    @classmethod
    def read(cls, results: Results, chosen: list[int], number_type: type[np.floating[Any]] = np.float32) -> Layers:
        """Read the chosen snapshots of a results folder, by their numbers; fields in a type that a page may shorten."""
        nodes: dict[str, list[Any]] = {}
        by_cell: dict[str, list[Any]] = {}
        for number in chosen:
            mesh = read_fields(results.folder / results.snapshots[number][1])
            for name, values in mesh.point_data.items():
                parts = [(name, values)] if values.ndim == 1 else zip(_along(name), values.T, strict=True)
                for part, column in parts:
                    nodes.setdefault(part, []).append(column.astype(number_type))
            for name, values in mesh.cell_data_dict.items():
                by_cell.setdefault(name, []).append(values["hexahedron"].astype(number_type))
        layer = by_cell.pop("layer")[0].astype(np.int64)
        times = np.array([results.snapshots[number][0] for number in chosen])
        whole = {name: np.stack(values) for name, values in nodes.items()}
        cells = {name: np.stack(values) for name, values in by_cell.items()}
        return cls(mesh.points, mesh.cells_dict["hexahedron"], layer, times, whole, cells)

    @property
    def heights(self) -> tuple[float, float]:
        """Of the undeformed bottom and top in m."""
        return float(self.points[:, 2].min()), float(self.points[:, 2].max())

    def volumes(self) -> Floats:
        """Of the undeformed cells in m3, exact for parallelepipeds, shape (cells,)."""
        corners = self.points[self.cells]
        edges = [corners[:, end] - corners[:, 0] for end in (1, 3, 4)]
        return np.abs(np.einsum("ij,ij->i", np.cross(edges[0], edges[1]), edges[2]))

    def face_nodes(self, layer: int, upper: bool) -> Integers:
        """Nodes of the upper or the lower face of a layer."""
        cells = np.flatnonzero(self.layer == layer)
        corners = self.points[self.cells[cells][:, FACES]]
        across = np.cross(corners[:, :, 2] - corners[:, :, 0], corners[:, :, 3] - corners[:, :, 1])
        level = across[:, :, 2] / np.maximum(np.linalg.norm(across, axis=2), 1e-300) * (1 if upper else -1)
        outer = (neighbours(self.cells, self.layer)[cells] < 0) & (level > 0.7)
        return np.unique(self.cells[cells][:, FACES][outer])


def _along(name: str) -> list[str]:
    return [f"{name}_{axis}" for axis in "xyz"]


def neighbours(cells: Integers, layer: Integers) -> Integers:
    """Cell of the same layer behind each face, -1 where there is none, shape (cells, 6)."""
    corners = np.sort(cells[:, FACES].reshape(-1, 4), axis=1)
    keys = np.column_stack([corners, np.repeat(layer, len(FACES))])
    order = np.lexsort(keys.T)
    same = (keys[order[1:]] == keys[order[:-1]]).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    behind = np.full(len(keys), -1)
    behind[first], behind[second] = second // len(FACES), first // len(FACES)
    return behind.reshape(-1, len(FACES))


def rigid_surfaces(results: Results, layers: Layers) -> list[dict[str, Any]]:
    """Tools and mould: name, grid of points relative to the tip in m, and the tip's path in m, a point a step."""
    scene = results.scene
    paths = np.array([tool_places.tips(scene, results.history, layers.heights, time) for time in layers.times])
    low, high = layers.points[:, :2].min(axis=0), layers.points[:, :2].max(axis=0)
    low, high = _whole(low, high, scene.stack.sides)
    margin = MARGIN * float((high - low).max())
    found = []
    for number, surface in enumerate(scene.rigid_surfaces):
        start, end = low - paths[:, number, :2].max(axis=0), high - paths[:, number, :2].min(axis=0)
        window = [(float(a) - margin, float(b) + margin) for a, b in zip(start, end, strict=True)]
        name = f"tool {number + 1}" if number < len(scene.tool) else "mould"
        found.append({"name": name, "grid": surface.surface((window[0], window[1])), "path": paths[:, number]})
    return found


def _whole(low: Floats, high: Floats, sides: Any) -> tuple[Floats, Floats]:
    """Extent with the mirror image at a plane of symmetry along each axis, shape (2,) each."""
    length = high - low
    for axis, name in enumerate("xy"):
        if getattr(sides, f"{name}_min") == "symmetry":
            low = low - length * np.eye(2)[axis]
        elif getattr(sides, f"{name}_max") == "symmetry":
            high = high + length * np.eye(2)[axis]
    return low, high


def mirrors(results: Results, layers: Layers) -> list[dict[str, Any]]:
    """Planes of symmetry, at most one along each axis: ``axis`` 0 or 1 and place ``at`` in m."""
    sides, found = results.scene.stack.sides, []
    for axis, name in enumerate("xy"):
        places = layers.points[:, axis].min(), layers.points[:, axis].max()
        symmetric = [getattr(sides, f"{name}_{end}") == "symmetry" for end in ("min", "max")]
        if any(symmetric):
            found.append({"axis": axis, "at": float(places[symmetric.index(True)])})
    return found


def lines_under(layers: Layers, face: Integers, tip: Floats) -> list[tuple[str, Integers]]:
    """Nodes of a face on the lines along x and along y nearest to a tip, in order; of 3 nodes or more."""
    found = []
    for along, across in ((0, 1), (1, 0)):
        distance = np.abs(layers.points[face, across] - tip[across])
        near = distance <= distance.min() + 1e-6 * np.ptp(layers.points[:, across])
        line = face[near][np.argsort(layers.points[face[near], along])]
        if len(line) > 2:
            found.append(("xy"[along], line))
    return found
