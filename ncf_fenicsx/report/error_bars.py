"""Which curves of a history have an error of their own, and what is said where they have none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ncf_fenicsx.report.reading import Results

FORCE, VF, VOIDS, WRINKLES = "Force", "Vf in the stack", "Volume of the voids", "Height of wrinkles"
"""Titles of curves whose error is known, or asked for."""
NO_BAND = {
    FORCE: "No error band: a single run does not tell the error of its force (time_error is that of the mean "
    "pressure, in one step). A run with --companion or --accuracy has a band.",
    VF: "No error band: vf_error is one number for the whole field. A run with --companion, or with --accuracy and "
    "vf among its quantities, has a band around the largest Vf.",
}


@dataclass(frozen=True)
class Largest:
    """The largest of some numbers of a history."""

    column: str
    row: int
    value: float


def largest(results: Results, columns: list[str]) -> Largest | None:
    """Column, row and value of the largest number in some columns of a history; None without any."""
    given = [column for column in columns if np.isfinite(results.history[column]).any()]
    found = [Largest(one, row, float(results.history[one][row])) for one in given for row in [_highest(results, one)]]
    return max(found, key=lambda one: one.value) if found else None


def _highest(results: Results, column: str) -> int:
    return int(np.nanargmax(results.history[column]))


def bars(results: Results) -> dict[str, dict[str, Any]]:
    """Error bars that a sequence of runs has given to its finest one, by the title of the curve that they are drawn on.

    Returns:
        Of each its column, its row counted from 0, half of its length in SI, and words.
    """
    voids = results.interface_columns("void_volume")
    columns = {
        "force": (FORCE, results.tool_columns("tool_force")),
        "vf": (VF, [name for name in ("vf_max",) if name in results.history]),
        "void_volume": (VOIDS, voids if len(voids) == 1 else []),
        "wrinkle_height": (WRINKLES, results.layer_columns("wrinkle_height")),
    }
    found = {}
    for quantity, known in results.record.get("accuracy", {}).get("quantities", {}).items():
        title, names = columns.get(quantity, ("", []))
        at = largest(results, names)
        if at is not None and known["bar"] is not None:
            words = f"The bar at the largest value: {known['bar_words']}."
            found[title] = {"column": at.column, "row": at.row, "half": known["bar"], "words": words}
    return found


def with_errors(curve: dict[str, Any], results: Results, known: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """A curve with its bands or its bar, and with what there is to say of them."""
    title = curve["title"]
    said = known[title]["words"] if title in known else ""
    found = {line["column"]: f"{line['column']}_error" for line in curve["lines"]}
    bands = {column: error for column, error in found.items() if _is_told(results, error)}
    if bands:
        words = f"The band is {' or '.join(bands.values())} on both sides."
        return curve | {"bands": bands, "note": f"{words} {said}".rstrip()}
    if said:
        bar = known[title]
        return curve | {"bar": {name: bar[name] for name in ("column", "row", "half")}, "note": said}
    return curve | {"note": NO_BAND.get(title, "")}


def _is_told(results: Results, error: str) -> bool:
    """Whether an error is known at some step: of a column of the history, or from a sequence of runs."""
    values = (results.history | results.errors).get(error)
    return values is not None and bool(np.isfinite(values).any())
