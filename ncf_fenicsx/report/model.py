"""What the 3-D view and the profiles of a page draw: a run's fields, so thinned out that a page stays small."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.report import encoding
from ncf_fenicsx.report.decimation import merged
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.surfaces import Floats, Integers, Layers, lines_under, mirrors, neighbours, rigid_surfaces
from ncf_fenicsx.report.thinning import evenly

LEAST_PRESSURE = 1e-3
"""Pressure over the largest one from which on a place is drawn as pressed."""
BESIDE = 4
"""Nodes that are drawn beside the pressed part of a line."""
FEW_STEPS = 8
"""Steps below which cells are made larger before more steps are left out."""
MOST_VALUES = 40_000_000
"""Values of fields that are read at most: more would take more memory than small runs do."""


@dataclass(frozen=True)
class Thinned:
    """A run's fields as far as a page has room for them.

    Attributes:
        layers: mesh and fields at the steps that are left.
        columns: of the permeability at these steps, of the whole mesh.
        nodes: number of each node in the field files.
        merged: cells along x and along y that have become one.
    """

    layers: Layers
    columns: dict[str, Floats]
    nodes: Integers
    merged: int = 1

    def at(self, kept: list[int]) -> Thinned:
        """Some of the steps."""
        layers = self.layers
        nodes = {name: values[kept] for name, values in layers.nodes.items()}
        by_cell = {name: values[kept] for name, values in layers.by_cell.items()}
        fewer = replace(layers, times=layers.times[kept], nodes=nodes, by_cell=by_cell)
        return replace(self, layers=fewer, columns={name: values[kept] for name, values in self.columns.items()})

    def coarser(self) -> Thinned | None:
        """Two by two cells as one; None where that cannot be."""
        found = merged(self.layers)
        if found is None:
            return None
        layers, kept = found
        return replace(self, layers=layers, nodes=self.nodes[kept], merged=2 * self.merged)


def encode_model(results: Results, most_bytes: int) -> dict[str, Any]:
    """Mesh, fields, tools and lines of a run as JSON.

    Steps are left out until it is small enough; where fewer than `FEW_STEPS` would be left, cells become larger first.

    Args:
        results: of the run.
        most_bytes: what it may take.

    Returns:
        Under ``why_not`` why there is none: no field file, or not even two steps of the coarsest mesh fit.
    """
    if not results.snapshots or not results.rows:
        return {"why_not": "There are no fields to draw."}
    count = len(results.snapshots)
    first = Layers.read(results, [0])
    values = sum(part.size for part in (*first.nodes.values(), *first.by_cell.values()))
    layers = Layers.read(results, evenly(count, max(MOST_VALUES // values, 2)))
    left = Thinned(layers, _snapshot_columns(layers), np.arange(len(layers.points)))
    few = min(FEW_STEPS, len(layers.times))
    while True:
        model = _encoded(results, left)
        size, steps = len(json.dumps(model)), len(left.layers.times)
        if size <= most_bytes:
            return model | {"steps_of_run": count}
        fewer = max(min(int(0.95 * steps * most_bytes / size), steps - 1), 2)
        coarser = left.coarser() if fewer < few else None
        if coarser is None and steps <= 2:
            return {"why_not": f"The fields of this run take too much room for a page: {len(layers.cells)} cells."}
        left = left.at(evenly(steps, fewer)) if coarser is None else coarser


def _encoded(results: Results, left: Thinned) -> dict[str, Any]:
    layers = left.layers
    surfaces = rigid_surfaces(results, layers)
    return {
        "points": encoding.numbers(layers.points.astype(np.float32)),
        "cells": encoding.table(layers.cells),
        "neighbours": encoding.table(neighbours(layers.cells, layers.layer)),
        "layer": encoding.table(layers.layer[:, None]),
        "layers": results.scene.stack.layers,
        "merged": left.merged,
        "node_numbers": encoding.table(left.nodes[:, None]) if left.merged > 1 else None,
        "times": layers.times.tolist(),
        "nodes": {name: encoding.series(values) for name, values in layers.nodes.items()},
        "by_cell": {name: encoding.series(values) for name, values in layers.by_cell.items()},
        "mirrors": mirrors(results, layers),
        "surfaces": [
            {
                "name": one["name"],
                "rows": one["grid"].shape[0],
                "grid": _rounded(one["grid"]),
                "path": _rounded(one["path"]),
            }
            for one in surfaces
        ],
        "lines": _lines(results, layers, surfaces),
        "snapshot_columns": {name: values.tolist() for name, values in left.columns.items()},
        "place": _place(layers, surfaces),
    }


def _rounded(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.7g}") for value in values.ravel()]


def _lines(results: Results, layers: Layers, surfaces: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Nodes that the pressure under each tool, and over the mould, is drawn along."""
    if "contact_pressure" not in layers.nodes:
        return []
    faces = layers.face_nodes(results.scene.stack.layers, True), layers.face_nodes(1, False)
    found = []
    for one in surfaces:
        face = faces[one["name"] == "mould"]
        for axis, line in lines_under(layers, face, one["path"][-1]):
            title = f"Pressure along {axis}, {one['name']}"
            line = pressed(line, layers.nodes["contact_pressure"][:, line])
            found.append({"title": title, "axis": "xy".index(axis), "nodes": line.tolist()})
    return found


def pressed(line: Integers, pressure: NDArray[np.float32]) -> Integers:
    """Part of a line that is ever pressed, with some nodes beside it; all of it where nothing is.

    Args:
        line: its nodes.
        pressure: at them, shape (steps, nodes of the line).
    """
    touched = np.flatnonzero(pressure.max(axis=0) > LEAST_PRESSURE * pressure.max(initial=0.0))
    if not len(touched):
        return line
    return line[max(touched[0] - BESIDE, 0) : touched[-1] + BESIDE + 1]


def _snapshot_columns(layers: Layers) -> dict[str, Floats]:
    """Smallest, mean and largest permeability of each step in m2, the mean by undeformed volume."""
    columns = {}
    volumes = layers.volumes()
    for name, values in layers.by_cell.items():
        if name.startswith("permeability"):
            columns[f"{name}_min"] = values.min(axis=1).astype(float)
            columns[f"{name}_mean"] = (values @ volumes / volumes.sum()).astype(float)
            columns[f"{name}_max"] = values.max(axis=1).astype(float)
    return columns


def _place(layers: Layers, surfaces: list[dict[str, Any]]) -> list[float]:
    """Place (x, y) in m that the profile through the stack is drawn at first: under the first tool, else the middle."""
    if surfaces and surfaces[0]["name"] != "mould":
        return _rounded(surfaces[0]["path"][-1, :2])
    return _rounded(layers.points[:, :2].mean(axis=0))
