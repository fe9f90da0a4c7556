"""A page of a study: one panel a question, interactive, and its table."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.markup import data, element, table
from ncf_fenicsx.report.page import PAGE, document

ERROR_TIME, STABILITY = "error_time.csv", "stability.csv"
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


def is_study(folder: Path) -> bool:
    """Whether a folder is that of a study."""
    return any((folder / name).is_file() for name in (ERROR_TIME, STABILITY))


def write_study(folder: Path) -> Path:
    """Write ``report.html`` of a study's folder.

    Raises:
        SceneError: its table cannot be read.
        ResultError: the page cannot be written.
    """
    name = ERROR_TIME if (folder / ERROR_TIME).is_file() else STABILITY
    try:
        with (folder / name).open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        panels = error_panels(rows) if name == ERROR_TIME else stability_panels(rows)
    except (OSError, ValueError, KeyError) as error:
        raise SceneError(f"{folder / name}: cannot be read: {error}; expected the table of a study") from error
    main = element("section", element("p", WORDS[name]) + '<div id="curves" class="study"></div>', aria_label="Panels")
    head = list(rows[0]) if rows else []
    main += element("section", table(name, head, [list(row.values()) for row in rows], wide=True), aria_label="Table")
    title = f"{TITLES[name]}: {folder.resolve().name}"
    page = document(title, main + data("panels", panels), ("vendor", "decode", "curve", "study"))
    replace(folder / PAGE, lambda beside: beside.write_text(page, encoding="utf-8"))
    return folder / PAGE


TITLES = {ERROR_TIME: "Error against run time", STABILITY: "How far a scene can be pushed"}
WORDS = {
    ERROR_TIME: "Each panel answers one question: what error does a run time buy? Down and to the left is better. "
    "The thick line joins the runs that no other beats in both. Press a name to hide or show a method.",
    STABILITY: "Each panel varies one input: the largest force of each case, and which cases stopped early. The table "
    "below has their values and reasons.",
}


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
        lines = [_line(name, [point for method, point in named if method == name]) for name in methods]
        lines.append(_line("best front", [(x, y, "") for x, y in front(points)]) | {"front": True})
        panels.append(
            _panel(words[0].upper() + words[1:], "run time in s, without compiling forms", words, lines, True)
        )
    return panels


def stability_panels(rows: list[Row]) -> list[Panel]:
    """A panel for each axis: force of the runs in the order of the table, those that stopped early apart."""
    panels = []
    for axis in dict.fromkeys(row["axis"] for row in rows):
        own = [row for row in rows if row["axis"] == axis]
        points = [(number, float(row["force_N"] or 0), row["value"]) for number, row in enumerate(own, start=1)]
        done = [row["ending"] == "done" for row in own]
        lines = [
            _line(label, [point for point, so in zip(points, done, strict=True) if so is wanted])
            for label, wanted in (("done", True), ("stopped early", False))
        ]
        drawn = [line for line in lines if line["points"]]
        panels.append(_panel(axis, "case, in the order of the table", "largest force in N", drawn, False))
    return panels


def _line(label: str, points: list[tuple[float, float, str]]) -> dict[str, Any]:
    """Points (x, y, name) under one label."""
    return {"label": label, "points": points}


def _panel(title: str, x: str, y: str, lines: list[dict[str, Any]], logarithmic: bool) -> Panel:
    return {"title": title, "x": x, "y": y, "lines": lines, "logarithmic": logarithmic}
