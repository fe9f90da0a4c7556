"""Which curves a page draws of a history: only those whose columns it has."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.report.error_bars import FORCE, VF, VOIDS, WRINKLES, bars, with_errors
from ncf_fenicsx.report.reading import Results

MM, KPA = 1e3, 1e-3

ERRORS, PIVOTS, PENETRATION, STEP_SIZES = (
    "Estimated errors and shares",
    "Negative pivots",
    "Deepest penetration",
    "Size of the steps",
)
"""Titles of curves that warnings point to."""

Lines = list[tuple[str, str]]
"""Columns of the history with their labels."""


def curves(results: Results) -> list[dict[str, Any]]:
    """Curves with title, unit, factor from SI to it, columns and labels, as JSON."""
    layers = [(f"vf_mean_layer_{n}", f"layer {n}") for n in range(1, results.scene.stack.layers + 1)]
    tools = range(len(results.scene.tool))
    forces = [(numbered("tool_force", n), f"tool {n + 1}") for n in tools] + [("support_force", "supports")]
    pressures = [(numbered("pressure_max", n), f"tool {n + 1}") for n in tools] + [("mould_pressure_max", "mould")]
    depths = [(numbered("penetration_max", n), f"tool {n + 1}") for n in tools] + [("mould_penetration_max", "mould")]
    widths = [(numbered("contact_width", n), f"along x, tool {n + 1}") for n in tools]
    widths += [(numbered("contact_length", n), f"along y, tool {n + 1}") for n in tools]
    at, waves = partial(_by_interface, results), partial(_by_layer, results)
    found = [
        _curve(FORCE, "N", 1, forces),
        _curve(VF, "1", 1, [("vf_min", "smallest"), ("vf_mean", "mean"), ("vf_max", "largest")]),
        _curve("Mean Vf of the layers", "1", 1, layers),
        _curve("Largest contact pressure", "kPa", KPA, pressures),
        _curve("Extent of the contact", "mm", MM, widths),
        _curve("Widest opening", "mm", MM, [*at("gap_max"), ("mould_gap_max", "stack and mould")]),
        _curve(VOIDS, "mm3", 1e9, [*at("void_volume"), ("mould_void_volume", "stack and mould")]),
        _curve("Largest slip of layers", "mm", MM, at("slip_max")),
        _curve(WRINKLES, "mm", MM, waves("wrinkle_height")),
        _curve("Wavelength of wrinkles", "mm", MM, waves("wrinkle_wavelength")),
        _curve(PENETRATION, "mm", MM, depths + at("interface_penetration_max")),
        _curve("Work", "J", 1, [("tool_work", "of the tools")]),
        _curve(
            ERRORS,
            "1",
            1,
            [
                ("vf_error", "of Vf by the mesh"),
                ("vf_error_in_plane", "of it in the plane"),
                ("time_error", "in time"),
                ("viscous_share", "viscous share"),
            ],
        ),
        _curve(PIVOTS, "1", 1, [("negative_pivots", "negative pivots")]),
        _curve("Iterations and cuts", "1", 1, [("newton_iterations", "iterations"), ("step_cuts", "cuts")]),
        _curve(STEP_SIZES, "s", 1, [("time_step", "step")]),
        _curve("Run time", "s", 1, [("wall_time", "wall time")]),
    ]
    history, known = results.history, bars(results)
    present = [one | {"lines": [line for line in one["lines"] if line["column"] in history]} for one in found]
    return [with_errors(one, results, known) for one in present if one["lines"]] + permeabilities(results)


def _curve(title: str, unit: str, scale: float, lines: Lines) -> dict[str, Any]:
    drawn = [{"column": column, "label": label} for column, label in lines]
    return {"id": anchor(title), "title": title, "unit": unit, "scale": scale, "lines": drawn, "table": "history"}


def anchor(title: str) -> str:
    """Where on a page the curve of that title is."""
    return "curve-" + "-".join(title.lower().split())


def _by_interface(results: Results, name: str) -> Lines:
    """Lines of a column that there is one of for each interface."""
    numbers = [(column, int(column.rsplit("_", 1)[1])) for column in results.interface_columns(name)]
    return [(column, f"layers {number} and {number + 1}") for column, number in numbers]


def _by_layer(results: Results, name: str) -> Lines:
    """Lines of a column that there is one of for each layer's upper face."""
    return [(column, f"top of layer {column.rsplit('_', 1)[1]}") for column in results.layer_columns(name)]


def permeabilities(results: Results) -> list[dict[str, Any]]:
    """Curves of the permeability, which stand in the field files and not in the history."""
    if results.scene.output.permeability is None:
        return []
    return [
        _curve(f"Permeability {way} the fibres", "m2", 1, [(f"permeability_{way}_{name}", name) for name in names])
        | {"table": "snapshots"}
        for way in ("along", "across")
        for names in [("min", "mean", "max")]
    ]


def abscissae(results: Results) -> list[dict[str, Any]]:
    """What curves can be drawn over, the best first: how far a tool has moved down only where it never goes back."""
    over = [{"column": "time", "label": "time", "unit": "s", "scale": 1}]
    for column in results.tool_columns("tool_displacement")[:1]:
        if (np.diff(results.history[column]) >= 0).all() and len(results.scene.segments) == 1:
            over.insert(0, {"column": column, "label": "tool displacement", "unit": "mm", "scale": MM})
    return over
