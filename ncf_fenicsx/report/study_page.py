"""A page of a study: what it comes to, one panel a question, interactive, and its table."""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.results_folder import ACCURACY
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.markup import data, element, folded, table, text
from ncf_fenicsx.report.page import PAGE, document
from ncf_fenicsx.report.sequence_panels import level_rows, sequence_panels
from ncf_fenicsx.report.study_panels import Panel, Row, error_panels, stability_panels
from ncf_fenicsx.report.sweep_panels import FINDINGS, MOST_LINES, parallel, sweep_panels
from ncf_fenicsx.report.thinning import evenly

SCRIPTS = ("vendor", "decode", "picture", "curve", "parallel", "study")
ERROR_TIME, STABILITY, SWEEP = "error_time.csv", "stability.csv", "rows.csv"


@dataclass(frozen=True)
class Study:
    """What a page shows of a study.

    Attributes:
        title: what the study is, in words.
        words: how to read the panels.
        panels: one a question.
        tables: caption, head and rows.
        answer: what it comes to, in sentences.
        across: runs as lines across parallel axes; None without.
    """

    title: str
    words: str
    panels: list[Panel]
    tables: list[tuple[str, list[str], list[list[str]]]]
    answer: list[str] = field(default_factory=list)
    across: dict[str, Any] | None = None


def is_study(folder: Path) -> bool:
    """Whether a folder is that of a study, or of a sequence of runs to an accuracy."""
    return any((folder / name).is_file() for name in READ)


def write_study(folder: Path) -> Path:
    """Write ``report.html`` of a study's folder.

    Raises:
        SceneError: its files cannot be read.
        ResultError: the page cannot be written.
    """
    name = next((name for name in READ if (folder / name).is_file()), STABILITY)
    try:
        study = READ[name](folder)
    except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
        raise SceneError(f"{folder / name}: cannot be read: {error}; expected the table of a study") from error
    return write_panels(folder / PAGE, f"{study.title}: {_subject(folder)}", study)


def _subject(folder: Path) -> str:
    """Title of the scene that a study is of, or the folder's name where there is none."""
    scene = folder / "scene.toml"
    title = tomllib.loads(scene.read_text(encoding="utf-8")).get("title") if scene.is_file() else None
    return f"{title or folder.resolve().name}"


def write_panels(path: Path, title: str, study: Study) -> Path:
    """Write a page of panels.

    Raises:
        ResultError: it cannot be written.
    """
    answer = "".join(element("li", text(words)) for words in study.answer)
    main = element("section", element("h2", "What it comes to") + element("ul", answer)) if answer else ""
    drawn = element("p", text(study.words)) + '<p class="row" id="groups"></p><div id="curves" class="study"></div>'
    main += element("section", drawn, aria_label="Panels")
    if study.across is not None and study.across["runs"]:
        main += element("section", element("h2", "All runs") + '<div id="parallel"></div>', aria_label="All runs")
    for caption, head, rows in study.tables:
        shown = table(caption, head, rows, wide=True)
        main += element("section", folded(caption, shown) if len(rows) > 20 else shown, aria_label="Table")
    page = document(title, main + data("panels", study.panels) + data("across", study.across), SCRIPTS)
    replace(path, lambda beside: beside.write_text(page, encoding="utf-8"))
    return path


def _rows(path: Path) -> list[Row]:
    """Rows of a table, without a last one that is just being written."""
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    return list(csv.DictReader(line for line in lines if line.endswith("\n")))


def _table(name: str, rows: list[Row]) -> tuple[str, list[str], list[list[str]]]:
    """Caption, head and rows of a table; thinned out where it is long."""
    places = evenly(len(rows), MOST_LINES)
    caption = name if len(places) == len(rows) else f"{name}, {len(places)} of {len(rows)} rows"
    return caption, list(rows[0]) if rows else [], [list(rows[place].values()) for place in places]


def _error_time(folder: Path) -> Study:
    rows = _rows(folder / ERROR_TIME)
    words = (
        "Each panel answers one question: what error does a run time buy? Down and to the left is better. "
        "The thick line joins the runs that no other beats in both. Press a name to hide or show a method."
    )
    return Study("Error against run time", words, error_panels(rows), [_table(ERROR_TIME, rows)])


def _stability(folder: Path) -> Study:
    rows = _rows(folder / STABILITY)
    words = (
        "Each panel varies one input: the largest force of each case, and which cases stopped early. The table "
        "below has their values and reasons."
    )
    return Study("How far a scene can be pushed", words, stability_panels(rows), [_table(STABILITY, rows)])


def _sweep(folder: Path) -> Study:
    rows, path = _rows(folder / SWEEP), folder / FINDINGS
    found = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"words": [], "panels": []}
    answer = found["words"] or ["The study has not ended: these are the runs so far."]
    panels = sweep_panels(rows, found["panels"])
    title, words = IN_WORDS[found["panels"][0]["kind"] if found["panels"] else "effect"]
    return Study(title, words, panels, [_table(SWEEP, rows)], answer, parallel(rows))


IN_WORDS = {
    "effect": (
        "What moves the results",
        "Thick lines are means of the runs, at each value of an input or in slices of equally many runs. Press a name "
        "to hide or show a line. Numbers are in SI units.",
    ),
    "estimates": (
        "Which inputs matter",
        "Each panel has a result, with the numbers of each input side by side. Press a name to hide or show it.",
    ),
    "distribution": (
        "How sure the results are",
        "Each panel has a result as it is distributed, with its median and where 90 of 100 cases lie.",
    ),
}
"""Title and words of the page of a study at many points, by the kind of what it has found."""


def _sequence(folder: Path) -> Study:
    answer = json.loads((folder / ACCURACY).read_text(encoding="utf-8"))
    levels = level_rows(answer)
    finest = f"level_{answer['levels'][-1]['level']}" if answer["levels"] else ""
    ending = f"{'The tolerance is met' if answer['met'] else 'The tolerance is not met'}: {answer['ending']}."
    told = [ending, *(f"{one}." for one in answer["words"])]
    words = (
        "Each panel has a quantity of the levels, from the coarsest on, over what they cost; bars are what was known "
        f"of each error by then. {finest} has the page of the finest run."
    )
    return Study("Accuracy", words, sequence_panels(answer), [("Levels", *levels)], told)


READ: dict[str, Callable[[Path], Study]] = {
    ACCURACY: _sequence,
    ERROR_TIME: _error_time,
    STABILITY: _stability,
    SWEEP: _sweep,
}
"""Files that tell what study a folder is of, and what reads it."""
