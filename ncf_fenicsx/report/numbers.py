"""The first screen of a page: how the run ended, the numbers that matter, and what to mind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import short

LARGE_ERROR = 0.1
"""Estimated error of the field of Vf, over its change, from which on it is a warning."""
DEEP = 0.02
"""Penetration over the travel of the tool from which on it is a warning."""
VISCOUS = 0.01
"""Share of the tools' work that viscosity has taken from which on it is a warning."""
UNBALANCED = 1e-4
"""What is left of the balance of forces, over the largest of them, from which on it is a warning."""


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


@dataclass(frozen=True)
class Warned:
    """A warning in words, and the anchor on the page that explains it."""

    words: str
    about: str


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
    found = [_force(results), _compaction(results), _void(results), _wrinkle(results), *_cost(results)]
    return [figure for figure in found if figure is not None]


def _largest(results: Results, columns: list[str]) -> tuple[str, int, float] | None:
    """Column, row and value of the largest number in some columns."""
    columns = [column for column in columns if np.isfinite(results.history[column]).any()]
    if not columns:
        return None
    rows = [int(np.nanargmax(results.history[column])) for column in columns]
    values = [float(results.history[column][row]) for column, row in zip(columns, rows, strict=True)]
    best = int(np.argmax(values))
    return columns[best], rows[best], values[best]


def _bar(results: Results, quantity: str, what: str = "") -> str:
    """Error bar of a quantity from a sequence of runs that this one was the finest of; empty without."""
    found = results.record.get("accuracy", {}).get("quantities", {}).get(quantity)
    return f"{what}{found['bar_words']}; " if found else ""


def _at(results: Results, row: int) -> str:
    return f"at {short(results.history['time'][row])} s"


def _force(results: Results) -> Figure | None:
    found = _largest(results, results.tool_columns("tool_force"))
    if found is None:
        return None
    column, row, value = found
    balance = f"forces balance to {short(unbalanced(results)[row])} N"
    error = f"{_bar(results, 'force')}{_at(results, row)}; {balance}"
    return Figure("Largest force on a tool", f"{short(value)} N", error, column, row)


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
    found = _largest(results, results.tool_columns("pressure_max"))
    if found is None:
        return None
    column, row, value = found
    return Figure("Largest contact pressure", f"{short(1e-3 * value)} kPa", _at(results, row), column, row)


def _void(results: Results) -> Figure | None:
    found = _largest(results, results.interface_columns("gap_max"))
    if found is None:
        return None
    column, row, value = found
    number = column.rsplit("_", 1)[1]
    deep = 1e3 * results.history[f"interface_penetration_max_{number}"][row]
    volume = _bar(results, "void_volume", "volume of all ")
    error = f"{volume}{_at(results, row)}, above layer {number}; faces penetrate by {short(deep)} mm"
    return Figure("Widest void", f"{short(1e3 * value)} mm", error, column, row)


def _wrinkle(results: Results) -> Figure | None:
    found = _largest(results, results.layer_columns("wrinkle_height"))
    if found is None:
        return None
    column, row, value = found
    number = column.rsplit("_", 1)[1]
    length = results.history[f"wrinkle_length_{number}"][row]
    shape = f"{short(1e3 * length)} mm long between its lift-off points" if length else "no crest"
    where = f"{_bar(results, 'wrinkle_height')}{_at(results, row)}, top of layer {number}; {shape}"
    return Figure("Highest wrinkle", f"{short(1e3 * value)} mm", where, column, row)


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


def warnings(results: Results) -> list[Warned]:
    """What to mind, each with the anchor of its explanation; the cautions of the run among it."""
    if not results.rows:
        return []
    found = _of_ending(results) + _of_contact(results) + _of_errors(results)
    return found + [Warned(words, "about-cautions") for words in results.record.get("cautions", [])]


def _of_ending(results: Results) -> list[Warned]:
    if not results.record:
        return [Warned("The run has not ended: the page shows what is written so far.", "about-ending")]
    if results.record["ending"] != "done":
        return [Warned(f"The run stopped early: {results.record['reason']}.", "about-ending")]
    return []


def _of_contact(results: Results) -> list[Warned]:
    history, found = results.history, []
    for name, moved in zip(
        results.tool_columns("penetration_max"), results.tool_columns("tool_displacement"), strict=False
    ):
        deep, travel = float(history[name].max()), float(np.abs(history[moved]).max())
        if deep > DEEP * travel > 0:
            words = f"{name}: the fabric penetrates a tool by {short(1e3 * deep)} mm, {100 * deep / travel:.2g} % of "
            found.append(Warned(f"{words}how far it moves.", "about-penetration"))
    return found


def _of_errors(results: Results) -> list[Warned]:
    history, found = results.history, []
    if "vf_error" in history and history["vf_error"][-1] > LARGE_ERROR:
        words = f"The mesh is coarse: the field of Vf is off by an estimated {100 * history['vf_error'][-1]:.2g} % of "
        found.append(Warned(f"{words}its change.", "about-error"))
    if history.get("viscous_share", np.zeros(1)).max() > VISCOUS:
        share = 100 * history["viscous_share"].max()
        found.append(Warned(f"Stabilising viscosity has taken {share:.2g} % of the tools' work.", "about-viscosity"))
    left, scale = unbalanced(results).max(), np.abs(history["support_force"]).max()
    if left > UNBALANCED * scale > 0:
        found.append(Warned(f"Forces balance only to {short(left)} N of {short(scale)} N.", "about-balance"))
    if history.get("negative_pivots", np.zeros(1)).max() > 0 and not results.record:
        when = history["time"][int(np.argmax(history["negative_pivots"] > 0))]
        found.append(Warned(f"Stability is lost at {short(when)} s.", "about-stability"))
    return found


EXPLAINED = {
    "about-ending": (
        "A run that stopped early",
        "All that the page shows was accepted and is on the disk. The reason says which limit was met. "
        "A run goes on with ncf-fenicsx run --restart FOLDER.",
    ),
    "about-penetration": (
        "Penetration",
        "A penalty lets faces penetrate a little. The force is then too low, for the tool has pressed less deep than "
        "it moved. Raise the penalty, or take another way to enforce contact.",
    ),
    "about-error": (
        "Estimated error of the mesh",
        "vf_error is a root mean square over the stack, relative to how much Vf has changed; no band around a curve. "
        "More elements along x and y take vf_error_in_plane away, more through the layers the rest; "
        "one element through each is the paper's model. It says nothing of errors of the laws.",
    ),
    "about-viscosity": (
        "Stabilising viscosity",
        "Where steps fail again and again a viscosity helps the stack over. What it takes of the work of the tools "
        "is missing elsewhere: forces are wrong by about that share.",
    ),
    "about-balance": (
        "Balance of forces",
        "What supports carry is the weight and the force of the tools. In an explicit run inertia is missing "
        "there, and in a stabilised one the viscosity.",
    ),
    "about-stability": (
        "Loss of stability",
        "From the first negative pivot on the stack may wrinkle in more than one way; the answer depends on the branch "
        "that was taken. The transverse shear modulus decides when that happens.",
    ),
    "about-cautions": (
        "Cautions of the run",
        "The program has found these in the scene or while it ran: values far from usual ones, a mesh that is coarse "
        "for its tool, a law beyond its data, a loss of stability (negative pivots).",
    ),
}
"""Titles and texts of what warnings point to, by anchor."""
