"""A page of a calibration: the fitted numbers, the laws over the data, and the residuals."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from ncf_fenicsx.calibration.plots import Floats, Panel
from ncf_fenicsx.report import study_panels
from ncf_fenicsx.report.study_page import Study, write_panels
from ncf_fenicsx.report.study_panels import Point
from ncf_fenicsx.report.thinning import evenly

MOST_ROWS = 400
"""Rows of a test that are drawn."""
READ = (
    "Points are measured, lines are the laws. Residuals of the right laws scatter about zero; what bends from row to "
    "row is a shape that the law has not. Press a name to hide or show it."
)


def write_page(path: Path, title: str, words: str, drawn: list[Panel]) -> Path:
    """Write a page.

    Args:
        path: of the page.
        title: of the fabric.
        words: what the fit comes to, as `in_words` says it.
        drawn: of `panels`.

    Raises:
        ResultError: it cannot be written.
    """
    lines = [line for line in words.splitlines() if line.strip()]
    tables = [_table(list(rows)) for is_table, rows in groupby(lines, lambda line: line.startswith("|")) if is_table]
    answer = [line for line in lines if not line.startswith("|")]
    study = Study("Calibration", READ, [_panel(one) for one in drawn], tables, answer)
    return write_panels(path, f"{study.title}: {title}", study)


def _table(lines: list[str]) -> tuple[str, list[str], list[list[str]]]:
    """Caption, head and rows of a table in words."""
    head, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return ("Tests" if head[0] == "test" else "Fitted numbers"), head, rows


def _panel(one: Panel) -> study_panels.Panel:
    """Measured points and the laws over them, in the same colour."""
    lines = []
    for number, (name, measured) in enumerate(one.points.items()):
        lines.append(study_panels.line(name, _points(*measured, name), apart=True, colour=number))
        if name in one.lines:
            lines.append(study_panels.line(f"{name}, law", _points(*one.lines[name], ""), traced=True, colour=number))
    lines += [
        study_panels.line(name, _points(*law, ""), traced=True)
        for name, law in one.lines.items()
        if name not in one.points
    ]
    title = one.title[0].upper() + one.title[1:]
    return study_panels.panel(title, *one.axes, lines)


def _points(x: Floats, y: Floats, name: str) -> list[Point]:
    """Points by name and row, thinned out evenly."""
    rows = evenly(len(x), MOST_ROWS)
    return [(float(x[row]), float(y[row]), f"row {row + 1}" if name else "") for row in rows]
