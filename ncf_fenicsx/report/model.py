"""What the 3-D view and the profiles of a page draw: a run's fields, so thinned out that a page stays small."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.report import encoding
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.surfaces import Integers, Layers, lines_under, mirrors, neighbours, rigid_surfaces
from ncf_fenicsx.report.thinning import evenly

LEAST_PRESSURE = 1e-3
"""Pressure over the largest one from which on a place is drawn as pressed."""
BESIDE = 4
"""Nodes that are drawn beside the pressed part of a line."""
MOST_VALUES = 40_000_000
"""Values of fields that are read at most: more would take more memory than small runs do."""


def encode_model(results: Results, most_bytes: int) -> dict[str, Any] | None:
    """Mesh, fields, tools and lines of a run as JSON.

    Args:
        results: of the run.
        most_bytes: what it may take; steps are left out until it does.

    Returns:
        None without a field file, or where not even two steps fit.
    """
    if not results.snapshots or not results.rows:
        return None
    count = len(results.snapshots)
    first = Layers.read(results, [0])
    values = sum(part.size for part in (*first.nodes.values(), *first.by_cell.values()))
    chosen = evenly(count, max(MOST_VALUES // values, 2))
    layers = Layers.read(results, chosen)
    while True:
        model = _encoded(results, layers)
        size = len(json.dumps(model))
        if size <= most_bytes:
            return model | {"steps_of_run": count}
        if len(layers.times) <= 2:
            return None
        fewer = max(min(int(0.95 * len(layers.times) * most_bytes / size), len(layers.times) - 1), 2)
        layers = _thinned(layers, evenly(len(layers.times), fewer))


def _thinned(layers: Layers, kept: list[int]) -> Layers:
    nodes = {name: values[kept] for name, values in layers.nodes.items()}
    by_cell = {name: values[kept] for name, values in layers.by_cell.items()}
    return Layers(layers.points, layers.cells, layers.layer, layers.times[kept], nodes, by_cell)


def _encoded(results: Results, layers: Layers) -> dict[str, Any]:
    surfaces = rigid_surfaces(results, layers)
    return {
        "points": encoding.numbers(layers.points.astype(np.float32)),
        "cells": encoding.table(layers.cells),
        "neighbours": encoding.table(neighbours(layers.cells, layers.layer)),
        "layer": encoding.table(layers.layer[:, None]),
        "layers": results.scene.stack.layers,
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
        "snapshot_columns": _snapshot_columns(layers),
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


def _snapshot_columns(layers: Layers) -> dict[str, list[float]]:
    """Smallest, mean and largest permeability of each step in m2, the mean by undeformed volume."""
    columns = {}
    volumes = layers.volumes()
    for name, values in layers.by_cell.items():
        if name.startswith("permeability"):
            columns[f"{name}_min"] = values.min(axis=1).astype(float).tolist()
            columns[f"{name}_mean"] = (values @ volumes / volumes.sum()).astype(float).tolist()
            columns[f"{name}_max"] = values.max(axis=1).astype(float).tolist()
    return columns


def _place(layers: Layers, surfaces: list[dict[str, Any]]) -> list[float]:
    """Place (x, y) in m that the profile through the stack is drawn at first: under the first tool, else the middle."""
    if surfaces and surfaces[0]["name"] != "mould":
        return _rounded(surfaces[0]["path"][-1, :2])
    return _rounded(layers.points[:, :2].mean(axis=0))
