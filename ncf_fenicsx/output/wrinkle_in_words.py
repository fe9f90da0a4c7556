"""The wrinkle that a run ends with: one sentence, and its numbers, from the rows of a history."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Tool

Floats = NDArray[np.float64]
Row = dict[str, float]

SEEN = 0.1
"""Height of a crest over a layer's thickness from which on it is called a wrinkle."""
MM, MM3 = 1e3, 1e9


@dataclass(frozen=True)
class Wrinkle:
    """The highest wrinkle of a row.

    Attributes:
        height_m: of its crest over the higher trough.
        lift_m: of its crest over where it would lie undeformed.
        length_m: between the places where the face lifts off.
        x_m: where its crest is.
        y_m: the same.
        count: crests on its line.
        slope_deg: largest angle of its face.
        curvature_per_m: largest curvature of its face.
        layers: numbers of the layers that have it, 1 at the bottom.
        void_m3: volume of all openings between layers and over the mould, of the whole.
        first_seen_s: when a wrinkle was first seen.
    """

    height_m: float
    lift_m: float
    length_m: float
    x_m: float
    y_m: float
    count: int
    slope_deg: float
    curvature_per_m: float
    layers: list[int]
    void_m3: float
    first_seen_s: float


def wrinkle_record(scene: Scene, history: list[Row]) -> dict[str, object]:
    """Entries of ``run.json``: ``wrinkle``, a sentence on the last row, and ``wrinkle_measures``, None without one.

    Args:
        scene: the case, its tools where they are.
        history: its rows; at least one.
    """
    wrinkle = last_wrinkle(scene, history)
    if wrinkle is None:
        return {"wrinkle": _nothing(scene, history), "wrinkle_measures": None}
    return {"wrinkle": _sentence(scene, history[-1]["time"], wrinkle), "wrinkle_measures": asdict(wrinkle)}


def last_wrinkle(scene: Scene, history: list[Row]) -> Wrinkle | None:
    """The highest wrinkle of the last row of a history; None if none is a tenth of a layer high.

    Args:
        scene: the case.
        history: its rows; at least one.
    """
    row = history[-1]
    faces = _faces(scene, row)
    if not faces:
        return None
    name = max(faces, key=lambda name: row[name.format("wrinkle_height")])
    height, lift, length, x, y, count = (
        row[name.format(f"wrinkle_{column}")] for column in ("height", "lift", "length", "x", "y", "count")
    )
    slope, curvature = np.degrees(row[name.format("misalignment_max")]), row[name.format("curvature_max")]
    void = sum(value for column, value in row.items() if "void_volume" in column)
    first = next(row["time"] for row in history if _faces(scene, row))
    layers = sorted(set(faces.values()))
    return Wrinkle(height, lift, length, x, y, int(count), float(slope), curvature, layers, void, first)


def _faces(scene: Scene, row: Row) -> dict[str, int]:
    """Layers of the faces with a wrinkle, by the pattern of their columns' names.

    A crest that only stands over what tools press down beside it has not risen, and is no wrinkle.
    """
    least = SEEN * scene.stack.thickness
    every = {f"{{}}_{layer}": layer for layer in range(1, scene.stack.layers + 1)} | {"mould_{}": 1}
    return {
        name: layer
        for name, layer in every.items()
        if min(row.get(name.format(column), 0.0) for column in ("wrinkle_height", "wrinkle_lift")) >= least
    }


def _nothing(scene: Scene, history: list[Row]) -> str:
    times = [row["time"] for row in history if _faces(scene, row)]
    least = f"{_number(MM * SEEN * scene.stack.thickness)} mm, a tenth of a layer's thickness"
    past = f"; one did from {times[0]:.4g} s to {times[-1]:.4g} s" if times else ""
    return f"no wrinkle: no crest stands out by {least}{past}"


def _sentence(scene: Scene, time: float, wrinkle: Wrinkle) -> str:
    what = "a wrinkle" if wrinkle.count == 1 else f"{wrinkle.count} wrinkles, the highest"
    size = f"{_number(MM * wrinkle.height_m)} mm high and {_number(MM * wrinkle.length_m)} mm long"
    parts = [f"{what} {size} in {_layers(scene, wrinkle.layers)}, crest {_place(scene, time, wrinkle)}"]
    if wrinkle.slope_deg > 90:
        parts.append(f"it overhangs: its face leans by {wrinkle.slope_deg:.0f} degrees and is no graph over x and y")
    parts.append(f"first seen at {wrinkle.first_seen_s:.4g} s")
    if wrinkle.void_m3:
        parts.append(f"void {_number(MM3 * wrinkle.void_m3)} mm3")
    return "; ".join(parts)


def _number(value: float) -> str:
    """Three digits, without an exponent."""
    return np.format_float_positional(value, 3, unique=False, fractional=False, trim="-")


def _layers(scene: Scene, layers: list[int]) -> str:
    of = scene.stack.layers
    if len(layers) == of:
        return {1: "the layer", 2: "both layers"}.get(of, f"all {of} layers")
    *others, last = map(str, layers)
    return f"layers {', '.join(others)} and {last}" if others else f"layer {last}"


def _place(scene: Scene, time: float, wrinkle: Wrinkle) -> str:
    """Where the crest is: seen from the nearest tool along the way that it last went, or in the stack's axes."""
    crest = np.array([wrinkle.x_m, wrinkle.y_m])
    if not scene.tool:
        x, y = crest
        return f"at x = {_number(MM * x)} mm, y = {_number(MM * y)} mm"
    away = {number: crest - tool.tip(0.0, time)[:2] for number, tool in enumerate(scene.tool)}
    nearest = min(away, key=lambda number: float(np.linalg.norm(away[number])))
    distance, name = away[nearest], numbered("the tool" if len(away) == 1 else "tool", nearest)
    way = _way(scene.tool[nearest], time)
    if way is None:
        return f"{_number(MM * float(np.linalg.norm(distance)))} mm from the middle of {name}"
    ahead = float(distance @ way)
    return f"{_number(MM * abs(ahead))} mm {'ahead of' if ahead >= 0 else 'behind'} the middle of {name}"


def _way(tool: Tool, time: float) -> Floats | None:
    """Horizontal direction that a tool has gone in last at a time (s), shape (2,); None if it never has."""
    for segment in reversed(tool.path[: motion.segment_number(tool.path, time) + 1]):
        travel = np.asarray(segment.travel or (0.0, 0.0, 0.0), dtype=np.float64)[:2]
        if travel.any():
            return travel / np.linalg.norm(travel)
    return None
