"""The first screen of a page: how the run ended, and the numbers that matter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ncf_fenicsx.report.error_bars import largest
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import short


@dataclass(frozen=True)
class Figure:
    """A number of the first screen.

    Attributes:
        name: what it is.
        value: in the unit shown, as text; with the unit.
        error: how far to believe it, in words.
        column: of the history that it stands in, "" for none.
        row: of the history, counted from 0.
    """

    name: str
    value: str
    error: str
    column: str = ""
    row: int = 0


def ending(results: Results) -> str:
    """How the run ended, in words."""
    if not results.rows:
        return "No step has been accepted yet."
    reached = f"{short(results.history['time'][-1])} s of {short(results.scene.milestones[-1])} s"
    if not results.record:
        return f"Not ended: {reached} are computed. The run goes on, or was killed."
    how = "Done" if results.record["ending"] == "done" else "Stopped early"
    return f"{how} at {reached}: {results.record['reason']}."


def figures(results: Results) -> list[Figure]:
    """The numbers that matter, of those that the run has."""
    if not results.rows:
        return []
    found = [_force(results), _compaction(results), _void(results), _off_the_mould(results), _wrinkle(results)]
    found += _cost(results)
    return [figure for figure in found if figure is not None]


def _bar(results: Results, quantity: str, what: str = "") -> str:
    """Error bar of a quantity from a sequence of runs that this one was the finest of; empty without."""
    found = results.record.get("accuracy", {}).get("quantities", {}).get(quantity)
    return f"{what}{found['bar_words']}; " if found else ""


def _at(results: Results, row: int) -> str:
    return f"at {short(results.history['time'][row])} s"


def _force(results: Results) -> Figure | None:
    found = largest(results, results.tool_columns("tool_force"))
    if found is None:
        return None
    balance = f"forces balance to {short(unbalanced(results)[found.row])} N"
    error = f"{_bar(results, 'force')}{_at(results, found.row)}; {balance}"
    return Figure("Largest force on a tool", f"{short(found.value)} N", error, found.column, found.row)


def unbalanced(results: Results) -> Any:
    """What is left of the balance of forces in each row of the history in N, without a sign."""
    history = results.history
    tools = sum(history[column] for column in results.tool_columns("tool_force"))
    return np.abs(history["support_force"] - history["weight"] - tools)


def _compaction(results: Results) -> Figure | None:
    history = results.history
    if np.isfinite(history.get("vf_max", np.nan)).any():
        row = int(np.nanargmax(history["vf_max"]))
        error = 100 * history["vf_error"][row]
        words = (
            f"the field of Vf is off by an estimated {error:.2g} % of its change" if error else "no estimate of error"
        )
        words = f"{_bar(results, 'vf')}{_at(results, row)}; {_bar(results, 'vf_field', 'its field ')}{words}"
        return Figure("Largest Vf", short(history["vf_max"][row]), words, "vf_max", row)
    found = largest(results, results.tool_columns("pressure_max"))
    if found is None:
        return None
    value = f"{short(1e-3 * found.value)} kPa"
    return Figure("Largest contact pressure", value, _at(results, found.row), found.column, found.row)


def _void(results: Results) -> Figure | None:
    found = largest(results, results.interface_columns("gap_max"))
    if found is None:
        return None
    column, row = found.column, found.row
    number = column.rsplit("_", 1)[1]
    deep = 1e3 * results.history[f"interface_penetration_max_{number}"][row]
    volume = _bar(results, "void_volume", "volume of all ")
    error = f"{volume}{_at(results, row)}, above layer {number}; faces penetrate by {short(deep)} mm"
    return Figure("Widest void", f"{short(1e3 * found.value)} mm", error, column, row)


def _off_the_mould(results: Results) -> Figure | None:
    """How far the stack ends off its mould, which is no void of the stack; None where it lies on it."""
    column, row = "mould_gap_max", results.rows - 1
    gap = float(results.history[column][row]) if column in results.history else 0.0
    if not gap > 0:
        return None
    volume = short(1e9 * results.history["mould_void_volume"][row])
    words = f"{_at(results, row)}, {volume} mm3 between stack and mould; not counted as a void"
    return Figure("Widest gap over the mould", f"{short(1e3 * gap)} mm", words, column, row)


def _wrinkle(results: Results) -> Figure | None:
    found = largest(results, results.layer_columns("wrinkle_height"))
    if found is None:
        return None
    column, row = found.column, found.row
    if not found.value:
        return Figure("Highest wrinkle", "0 mm", "no crest on any layer at any time", column, row)
    number = column.rsplit("_", 1)[1]
    length = results.history[f"wrinkle_length_{number}"][row]
    shape = f"{short(1e3 * length)} mm long between its lift-off points" if length else "no crest"
    where = f"{_bar(results, 'wrinkle_height')}{_at(results, row)}, top of layer {number}; {shape}"
    return Figure("Highest wrinkle", f"{short(1e3 * found.value)} mm", where, column, row)


def _cost(results: Results) -> list[Figure]:
    history, record = results.history, results.record
    row = results.rows - 1
    iterations = f", {int(history['newton_iterations'].sum())} iterations" if "newton_iterations" in history else ""
    cost = f"{row} steps{iterations}"
    if record:
        ranks = f"{record['ranks']} rank" + ("s" if record["ranks"] > 1 else "")
        cost += f"; {record['unknowns']} unknowns, {ranks}, {record['peak_memory_mb']:.0f} MB"
    reached = Figure("Time reached", f"{short(history['time'][row])} s", cost, "time", row)
    return [reached, Figure("Run time", f"{short(history['wall_time'][row])} s", "wall time", "wall_time", row)]
