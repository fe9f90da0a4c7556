"""A page of a study: one panel a question, interactive, and its table."""

from __future__ import annotations

import csv
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.markup import data, element, table
from ncf_fenicsx.report.page import PAGE, document
from ncf_fenicsx.units import parse_number

ERROR_TIME, STABILITY, SWEEP = "error_time.csv", "stability.csv", "rows.csv"
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
Point = tuple[float, float, str]
"""x, y and name."""


def is_study(folder: Path) -> bool:
    """Whether a folder is that of a study."""
    return any((folder / name).is_file() for name in (ERROR_TIME, STABILITY, SWEEP))


def write_study(folder: Path) -> Path:
    """Write ``report.html`` of a study's folder.

    Raises:
        SceneError: its table cannot be read.
        ResultError: the page cannot be written.
    """
    name = next((name for name in PANELS if (folder / name).is_file()), STABILITY)
    try:
        with (folder / name).open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        panels = PANELS[name](rows)
    except (OSError, ValueError, KeyError) as error:
        raise SceneError(f"{folder / name}: cannot be read: {error}; expected the table of a study") from error
    main = element("section", element("p", WORDS[name]) + '<div id="curves" class="study"></div>', aria_label="Panels")
    head = list(rows[0]) if rows else []
    main += element("section", table(name, head, [list(row.values()) for row in rows], wide=True), aria_label="Table")
    title = f"{TITLES[name]}: {folder.resolve().name}"
    page = document(title, main + data("panels", panels), ("vendor", "decode", "picture", "curve", "study"))
    replace(folder / PAGE, lambda beside: beside.write_text(page, encoding="utf-8"))
    return folder / PAGE


MOST_VALUES = 12
"""Values of an input up to which a mean is of each."""
RUN = "run"
"""Column between inputs and results of a sweep."""
TITLES = {
    ERROR_TIME: "Error against run time",
    STABILITY: "How far a scene can be pushed",
    SWEEP: "What moves the results",
}
WORDS = {
    ERROR_TIME: "Each panel answers one question: what error does a run time buy? Down and to the left is better. "
    "The thick line joins the runs that no other beats in both. Press a name to hide or show a method.",
    STABILITY: "Each panel varies one input: the largest force of each case, and which cases stopped early. The table "
    "below has their values and reasons.",
    SWEEP: "Each panel holds one result against one input: a point for each run that is done, and the mean at each "
    "value, or in each sixth of the runs, as a thick line. The table below has all runs.",
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


def sweep_panels(rows: list[Row]) -> list[Panel]:
    """A panel for each result over each input that is a number: the runs, and means at values or in sixths of runs."""
    headings = list(rows[0]) if rows else []
    inputs, results = headings[: headings.index(RUN)], headings[headings.index(RUN) + 1 : -2]
    panels = []
    for result in results:
        given = [row for row in rows if row[result]]
        for one in inputs:
            points = [(parse_number(row[one]), float(row[result]), row[RUN]) for row in given]
            numbers = sorted((x, y, name) for x, y, name in points if x is not None)
            if numbers and len(numbers) == len(points):
                lines = [_line("run", numbers), _line("mean", _means(numbers)) | {"front": True}]
                panels.append(_panel(f"{result} over {one}", one, result, lines, False))
    return panels


def _means(points: list[Point]) -> list[Point]:
    """Mean points at each of a few values, or of sixths of sorted points."""
    values = dict.fromkeys(x for x, _, _ in points)
    groups = [[point for point in points if point[0] == x] for x in values]
    if len(values) > MOST_VALUES:
        ends = [len(points) * part // 6 for part in range(7)]
        groups = [points[start:end] for start, end in pairwise(ends)]
    return [(fmean(x for x, _, _ in group), fmean(y for _, y, _ in group), "") for group in groups]


def _line(label: str, points: list[Point]) -> dict[str, Any]:
    """Points (x, y, name) under one label."""
    return {"label": label, "points": points}


def _panel(title: str, x: str, y: str, lines: list[dict[str, Any]], logarithmic: bool) -> Panel:
    return {"title": title, "x": x, "y": y, "lines": lines, "logarithmic": logarithmic}


PANELS = {ERROR_TIME: error_panels, STABILITY: stability_panels, SWEEP: sweep_panels}
"""Tables of studies, and what their panels are made by."""
