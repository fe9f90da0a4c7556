"""Panels of studies of error against run time and of stability: one question each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

ERRORS = {
    "force_error": "error of the largest force",
    "vf_max_error": "error of the largest Vf",
    "vf_field_error": "error of the field of Vf",
    "void_error": "error of the volume of the voids",
}
"""Columns of errors of the study of error against time, with what they are."""
LEAST = 1e-6
"""Errors below this are drawn there: the logarithm of none is nowhere."""

Row = dict[str, str]
Panel = dict[str, Any]
"""Title, words at x and y, lines; and for other than linear axes ``logarithmic`` ("x" or "both"); ``names`` of the
places 1, 2 and so on along x; ``note`` below; ``group`` of panels that are shown together."""
Point = tuple[float, float, str] | tuple[float, float, str, float, float]
"""x, y and name; with an error also its ends."""


def line(label: str, points: Sequence[Point], **more: Any) -> dict[str, Any]:
    """Points under one label; more as ``front`` (a thick line), ``apart`` (points without a line)."""
    return {"label": label, "points": points, **more}


def panel(title: str, x: str, y: str, lines: list[dict[str, Any]], **more: Any) -> Panel:
    """A panel; more as in `Panel`."""
    return {"title": title, "x": x, "y": y, "lines": [one for one in lines if one["points"]], **more}


def front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points (time, error) that none beats in both, by time."""
    best: list[tuple[float, float]] = []
    for point in sorted(points):
        if not best or point[1] < best[-1][1]:
            best.append(point)
    return best


def error_panels(rows: list[Row]) -> list[Panel]:
    """A panel for each error that rows have: points of each method, and the best front."""
    panels = []
    for column, words in ERRORS.items():
        given = [row for row in rows if row.get(column)]
        if not given:
            continue
        points = [(float(row["seconds"]), max(float(row[column]), LEAST)) for row in given]
        named = [(row["method"], (*point, row["level"])) for row, point in zip(given, points, strict=True)]
        methods = dict.fromkeys(method for method, _ in named)
        lines = [line(name, [point for method, point in named if method == name]) for name in methods]
        lines.append(line("best front", [(x, y, "") for x, y in front(points)], front=True))
        title = words[0].upper() + words[1:]
        panels.append(panel(title, "run time in s, without compiling forms", words, lines, logarithmic="both"))
    return panels


def stability_panels(rows: list[Row]) -> list[Panel]:
    """A panel for each axis: force of the runs in the order of the table, those that stopped early apart."""
    panels = []
    for axis in dict.fromkeys(row["axis"] for row in rows):
        own = [row for row in rows if row["axis"] == axis]
        points = [(number, float(row["force_N"] or 0), row["value"]) for number, row in enumerate(own, start=1)]
        done = [row["ending"] == "done" for row in own]
        lines = [
            line(label, [point for point, so in zip(points, done, strict=True) if so is wanted], apart=True)
            for label, wanted in (("done", True), ("stopped early", False))
        ]
        names = [row["value"] for row in own]
        panels.append(panel(axis, axis, "largest force in N", lines, names=names))
    return panels
