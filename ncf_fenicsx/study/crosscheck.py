"""Histories of another code against the reference solutions of the cross-check kit, with their error bars."""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.study.comparison import Comparison, Curves
from ncf_fenicsx.version import VERSION

Floats = NDArray[np.float64]

NAMES = "columns.toml"
"""File beside the histories of another code that says what its headings mean."""
OVER = ("time", "tool_displacement")
"""What a history may be held over, the first that it has."""
WHOLE = 0.95
"""Share of the reference that a history has to cover to be whole."""


@dataclass(frozen=True)
class Reference:
    """A history of the kit.

    Attributes:
        name: of the history; another code's file is called so.
        curves: values.
        bars: how far each value may be off the exact solution of the case, by column.
        judged: columns that count.
        tolerance: share of a column's largest size that another code may be off beside the bar.
        not_judged: stretches of time in s where the force jumps.
    """

    name: str
    curves: Curves
    bars: dict[str, Floats]
    judged: tuple[str, ...]
    tolerance: float
    not_judged: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Verdict:
    """What is said of a column of a history.

    Attributes:
        history: its name.
        column: its name; empty for a whole history.
        passed: whether it is within the tolerance and the bar everywhere; None where it was not given.
        words: how far it is off, and where; or what is missing.
    """

    history: str
    column: str
    passed: bool | None
    words: str


def read_kit(folder: Path) -> list[Reference]:
    """All histories of a kit, case by case.

    Raises:
        SceneError: it is no kit.
    """
    found = []
    for file in sorted(folder.glob("*/case.json")):
        try:
            case = json.loads(file.read_text(encoding="utf-8"))
            found += [_reference(file.parent, case, name) for name in case["histories"]]
        except (OSError, ValueError, KeyError) as error:
            raise SceneError(f"{file}: cannot be read: {error!r}; expected a case of a cross-check kit") from error
    if not found:
        raise SceneError(f"--kit {folder}: has no */case.json; expected the folder demos/crosscheck of a checkout")
    return found


def _reference(folder: Path, case: dict[str, Any], name: str) -> Reference:
    path = folder / f"{name}.csv"
    rows, judged = read_history(path), tuple(case["judged"])
    bars = {column: rows[f"{column}_bar"] for column in judged}
    not_judged = tuple((float(start), float(end)) for start, end in case["histories"][name]["not_judged"])
    return Reference(name, Curves.read(path), bars, judged, float(case["tolerance"]), not_judged)


def judge(folder: Path, kit: Path, tolerance: float | None) -> list[Verdict]:
    """Judge the histories in a folder: files ``NAME.csv``, or folders ``NAME`` with a ``history.csv``.

    Args:
        folder: of another code's histories, of which it may have some. Its ``columns.toml`` names their columns.
        kit: folder of the cases.
        tolerance: in place of those of the cases.

    Raises:
        SceneError: there is no history, or one cannot be read.
    """
    references, names = read_kit(kit), _names(folder)
    verdicts: list[Verdict] = []
    for reference in references:
        places = (folder / f"{reference.name}.csv", folder / reference.name / "history.csv")
        path = next((place for place in places if place.is_file()), None)
        if path is None:
            verdicts.append(Verdict(reference.name, "", None, f"no {reference.name}.csv"))
        else:
            verdicts += _judge_history(Curves.read(path, names), reference, tolerance)
    if all(verdict.passed is None for verdict in verdicts):
        expected = ", ".join(f"{reference.name}.csv" for reference in references)
        raise SceneError(f"{folder}: has no history with a column to judge; expected some of {expected}")
    return verdicts


def _names(folder: Path) -> dict[str, str]:
    """What headings mean, from ``columns.toml``."""
    path = folder / NAMES
    if not path.exists():
        return {}
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {error}; expected lines such as 'RF3' = '-tool_force [kN]'") from error
    for heading, meaning in table.items():
        if not isinstance(meaning, str):
            raise SceneError(f"{path}: {heading} = {meaning}; expected a text such as 'tool_force [kN]'")
    return table


def _judge_history(history: Curves, reference: Reference, tolerance: float | None) -> list[Verdict]:
    over = next((name for name in OVER if name in history.columns), None)
    if over is None or (np.diff(reference.curves.columns[over]) < 0).any():
        return [Verdict(reference.name, "", None, "no column time to hold it over")]
    verdicts = []
    for column in reference.judged:
        if column in history.columns:
            verdicts.append(_judge_column(history, reference, column, over, tolerance))
        else:
            verdicts.append(Verdict(reference.name, column, None, "no such column"))
    return verdicts


def _judge_column(history: Curves, reference: Reference, column: str, over: str, tolerance: float | None) -> Verdict:
    comparison = Comparison(history, reference.curves, [column], over)
    places, ours, theirs = comparison.on_both(column)
    positions = reference.curves.columns[over]
    bars = np.interp(places, positions, reference.bars[column])
    times = np.interp(places, positions, reference.curves.columns["time"])
    counted = np.ones(len(times), dtype=bool)
    for start, end in reference.not_judged:
        counted &= (times <= start * (1 - 1e-9)) | (times >= end)
    if not counted.any():
        return Verdict(reference.name, column, None, "no row where it is judged")
    largest = np.abs(reference.curves.columns[column]).max()
    off = np.where(counted, np.abs(ours - theirs), 0.0)
    allowed = (reference.tolerance if tolerance is None else tolerance) * largest + bars
    worst = int((off / allowed).argmax())
    words = (
        f"off by {100 * off[worst] / largest:.2g} % (bar {100 * bars[worst] / largest:.1g} %) at {times[worst]:.6g} s"
    )
    share = np.ptp(places) / np.ptp(positions)
    if share < WHOLE:
        words += f"; only {places[0]:.4g} to {places[-1]:.4g} of {over} ({100 * share:.0f} %)"
    return Verdict(reference.name, column, bool((off <= allowed).all()), words)


def table(verdicts: list[Verdict]) -> str:
    """Verdicts as a Markdown table, with a line to paste below it."""
    said = {True: "passed", False: "FAILED", None: "not given"}
    lines = ["| history | column | | of the column's largest size |", "|---|---|---|---|"]
    lines += [f"| {one.history} | {one.column} | {said[one.passed]} | {one.words} |" for one in verdicts]
    return "\n".join([*lines, "", badge(verdicts)])


def badge(verdicts: list[Verdict]) -> str:
    """One line on how a code did: columns passed, failed and not given."""
    counts = [sum(one.passed is state for one in verdicts) for state in (True, False, None)]
    passed, failed, missing = counts
    return f"cross-check of ncf_fenicsx {VERSION}: {passed} passed, {failed} failed, {missing} not given"


def holds(verdicts: list[Verdict]) -> bool:
    """Whether nothing that was given has failed."""
    return all(one.passed is not False for one in verdicts)
