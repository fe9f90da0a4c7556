"""Errors of the finest run at each of its steps, from the histories of all levels."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ncf_fenicsx.accuracy.answer import Answer
from ncf_fenicsx.accuracy.extrapolation import estimate
from ncf_fenicsx.accuracy.quantities import QUANTITIES
from ncf_fenicsx.output.results_folder import ERROR_BANDS
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.reading import Results


def write_bands(answer: Answer) -> None:
    """Write ``error_bands.csv`` beside the finest history, with a row for each of its rows.

    A sequence of one level has no bars, and gets no file.

    Raises:
        ResultError: it cannot be written.
    """
    if len(answer.levels) < 2:
        return
    levels = [Results.read(level.folder) for level in answer.levels]
    finest = levels[-1]
    asked = [QUANTITIES[name].column for name in answer.quantities]
    columns = [name for column in asked if column for name in _of_all_tools(finest, column)]
    found = {f"{column}_error": errors(levels, column, answer.branches) for column in columns}
    rows = [("time", *found), *zip(finest.history["time"], *found.values(), strict=True)]
    replace(finest.folder / ERROR_BANDS, lambda beside: _write(beside, rows))


def errors(levels: Sequence[Results], column: str, branches: bool = False) -> Any:
    """How far a column may be off at each row of the finest history: bars of the levels' values at its times.

    Args:
        levels: from the coarsest on; two at least.
        column: of their histories.
        branches: whether the levels may follow different branches.
    """
    times = levels[-1].history["time"]
    values = [np.interp(times, level.history["time"], level.history[column]) for level in levels]
    return np.array([estimate(list(row), branches).bar for row in np.transpose(values)])


def _of_all_tools(results: Results, column: str) -> list[str]:
    return results.tool_columns(column) if column == "tool_force" else [column]


def _write(path: Path, rows: list[tuple[Any, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
