"""One page of several runs: how their inputs differ, their numbers, curves over each other, linked views."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.markup import element, table
from ncf_fenicsx.report.numbers import ending, figures
from ncf_fenicsx.report.page import places, run_data, spare, view, write_page
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import sentence

MOST_RUNS = 6
"""Runs on a page: browsers keep some ten 3-D views alive, and colours tell that many apart."""
ABSENT = "–"


def write_comparison(folders: Sequence[Path], path: Path) -> Path:
    """Write a page that compares results folders.

    Args:
        folders: two or more.
        path: of the page.

    Raises:
        SceneError: too many folders, or one is no results folder.
        ResultError: the page cannot be written.
    """
    if len(folders) > MOST_RUNS:
        raise SceneError(f"report: {len(folders)} folders; expected at most {MOST_RUNS} on a page")
    runs = [Results.read(folder) for folder in folders]
    names = _names(folders)
    main = element("section", _overview(runs, names) + _inputs(runs, names), aria_label="Overview")
    unseen = '<div id="fallback"><p id="no-view" role="status"></p></div>'
    main += view(len(runs), unseen) + places()
    each = spare(main) // len(runs)
    drawn = [run_data(results, each) | {"name": name} for results, name in zip(runs, names, strict=True)]
    return write_page(path, "Comparison of " + ", ".join(names), main, drawn)


def _names(folders: Sequence[Path]) -> list[str]:
    """Names of the folders, with those above them where they are not enough to tell them apart."""
    short = [folder.resolve().name for folder in folders]
    return short if len(set(short)) == len(short) else [str(folder) for folder in folders]


def _overview(runs: list[Results], names: list[str]) -> str:
    """Sentence, ending and numbers of each run."""
    found = [{figure.name: figure.value for figure in figures(results)} for results in runs]
    rows = [["ending", *(ending(results) for results in runs)]]
    titles = list(dict.fromkeys(name for one in found for name in one))
    rows += [[title, *(one.get(title, ABSENT) for one in found)] for title in titles]
    rows.append(["case", *(sentence(results) for results in runs)])
    return table("The numbers that matter", ("", *names), rows)


def _inputs(runs: list[Results], names: list[str]) -> str:
    """Keys of the scenes that are not the same in all runs."""
    tables = [dict(_flat(results.scene.table())) for results in runs]
    keys = sorted(set().union(*tables))
    rows = [[key, *(tables_of.get(key, ABSENT) for tables_of in tables)] for key in keys]
    different = [row for row in rows if len(set(row[1:])) > 1]
    if not different:
        return element("p", "All inputs are the same.")
    return table("Inputs that differ, in SI units", ("key", *names), different)


def _flat(value: Any, path: str = "") -> list[tuple[str, str]]:
    """Keys of nested tables with their values as text; numbers in a key count from 0, as with ``--set``."""
    if isinstance(value, dict):
        parts = value.items()
    elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
        parts = dict(enumerate(value)).items()
    else:
        return [(path, str(value))]
    return [pair for key, item in parts for pair in _flat(item, f"{path}.{key}" if path else str(key))]
