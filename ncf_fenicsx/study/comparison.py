"""Two histories held against each other: how far a column of one is off that of the other, in a table and a picture."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.measures import COLUMNS
from ncf_fenicsx.parameters.units import parse_number, parse_quantity

Floats = NDArray[np.float64]

HEADING = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(\[(?P<unit>[^\[\]]*)\])?\s*")
NUMBER = re.compile(r"(_layer)?_\d+$")
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


JUDGED = re.compile(r"(tool_force|vf_mean|vf_max|gap_max|void_volume)(_\d+)?")
"""Columns that are compared unless others are asked for: force, Vf, gaps."""
COARSE = 0.05
"""Share of what is compared that an interval of the reference may cover before its straight line is doubted."""
MOST_ACROSS = 4


def unit_of(column: str) -> str | None:
    """SI unit of a column of ``history.csv``; None of one that it does not have."""
    plain = NUMBER.sub("", column.removeprefix("mould_"))
    known = COLUMNS.get(column) or COLUMNS.get(plain) or COLUMNS.get(f"{plain}_N")
    return known[0] if known else None


@dataclass(frozen=True)
class Curves:
    """A history.

    Attributes:
        path: its file.
        columns: values in SI by name, NaN where the file has none.
    """

    path: Path
    columns: dict[str, Floats]

    @classmethod
    def read(cls, path: Path, names: dict[str, str] | None = None) -> Curves:
        """History from a CSV file with a heading: names as in ``history.csv``, in SI, or with a unit: ``force [kN]``.

        Columns that ``history.csv`` does not have are left out.

        Args:
            path: of the file.
            names: what a heading of the file means, where it is none of these: ``{"RF3": "-tool_force [kN]"}``. A
                leading minus turns the sign.

        Raises:
            SceneError: the file cannot be read, or a unit or value in it is not valid.
        """
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                heading, *rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)] or [[]]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            reason = getattr(error, "strerror", None) or error
            raise SceneError(f"{path}: {reason}; expected a history as CSV") from error
        _check_separators(path, heading, rows)
        columns = {}
        for number, text in enumerate(heading):
            meant = (names or {}).get(text.strip(), text)
            name, factor = _column(path, meant.removeprefix("-"))
            if name in columns:
                raise SceneError(f"{path}: column {name} is there twice; expected once")
            if factor is not None:
                sign = -1.0 if meant.startswith("-") else 1.0
                columns[name] = sign * factor * np.array([_value(path, name, row, number) for row in rows])
        if len(rows) < 2:
            raise SceneError(f"{path}: {len(rows)} rows; expected a heading and two rows or more")
        return cls(path, columns)

    def over(self, abscissa: str, column: str) -> tuple[Floats, Floats]:
        """A column where it has values, over another one that has to grow.

        Raises:
            SceneError: a column is missing, or has fewer than two values, or the other one does not grow.
        """
        for name in (abscissa, column):
            if name not in self.columns:
                raise SceneError(f"{self.path}: no column {name}; expected one of {', '.join(self.columns)}")
        x, y = self.columns[abscissa], self.columns[column]
        there = np.isfinite(x) & np.isfinite(y)
        x, y = x[there], y[there]
        if len(x) < 2:
            raise SceneError(f"{self.path}: {len(x)} values of {column}; expected two or more")
        if (np.diff(x) < 0).any():
            raise SceneError(f"{self.path}: {abscissa} goes back; expected values that grow")
        return x, y


def _column(path: Path, heading: str) -> tuple[str, float | None]:
    """Name of a column and factor to SI; None for one that is not known."""
    match = HEADING.fullmatch(heading)
    if match is None:
        raise SceneError(f"{path}: column {heading!r}; expected a name, or a name and [unit]")
    name, unit = match["name"], match["unit"]
    wanted = unit_of(name)
    if wanted is None or unit is None:
        return name, None if wanted is None else 1.0
    factor = 1.0 if unit == wanted == "1" else parse_quantity(f"1 {unit}", wanted)
    if factor is None:
        raise SceneError(f"{path}: column {name} in {unit!r}; expected a unit of {wanted}")
    return name, factor


def _value(path: Path, name: str, row: list[str], number: int) -> float:
    text = row[number].strip() if number < len(row) else ""
    value = parse_number(text) if text and text.lower() != "nan" else math.nan
    if value is None:
        raise SceneError(f"{path}: {name} = {text!r}; expected a number with a decimal point, such as 1.2e-3")
    return value


def _check_separators(path: Path, heading: list[str], rows: list[list[str]]) -> None:
    """Raise a SceneError that names a separator other than a comma, or a row that is longer than the heading."""
    found = next((name for mark, name in SEPARATORS.items() if len(heading) == 1 and mark in heading[0]), None)
    if found is not None:
        raise SceneError(f"{path}: {found} separate the columns; expected commas, and points in numbers")
    for number, row in enumerate(rows, 2):
        if len(row) > len(heading):
            text = ",".join(row)
            raise SceneError(f"{path}: line {number} has {len(row)} values ({text}); expected {len(heading)}")


@dataclass(frozen=True)
class Difference:
    """How far a column is off that of a reference, at the rows of the history that it covers.

    Attributes:
        column: its name.
        largest: largest size in the reference, in SI.
        worst: largest difference over that; infinite where the reference is 0 and the other is not.
        where: abscissa of the largest difference.
        mean_square: root of the mean square difference, over the largest size.
        last: difference at the end of what is compared, over the largest size.
    """

    column: str
    largest: float
    worst: float
    where: float
    mean_square: float
    last: float


class Comparison:
    """The rows of a history against a reference, whose curves are straight between its own rows.

    Args:
        history: what is judged.
        reference: what it is held against.
        columns: to compare; those of force, Vf and gaps that both have, unless given.
        over: column that curves are drawn over.

    Attributes:
        differences: of each column.

    Raises:
        SceneError: a column is missing or unknown, or the two have no stretch in common.
    """

    def __init__(self, history: Curves, reference: Curves, columns: list[str] | None, over: str = "time") -> None:
        self.history, self.reference, self.abscissa = history, reference, over
        for name in (over, *(columns or ())):
            if unit_of(name) is None:
                raise SceneError(f"compare: column {name!r}; expected a column of history.csv")
        common = [name for name in reference.columns if name in history.columns and JUDGED.fullmatch(name)]
        self.columns = columns or common
        if not self.columns:
            raise SceneError(f"compare: {history.path} and {reference.path} share no column of force, Vf or gaps")
        self.differences = [self._difference(name) for name in self.columns]

    def on_both(self, column: str) -> tuple[Floats, Floats, Floats]:
        """Rows of the history in the stretch that both share: their positions, and the values of both there."""
        (x, y), (x_ref, y_ref) = self.history.over(self.abscissa, column), self.reference.over(self.abscissa, column)
        begin, end = max(x[0], x_ref[0]), min(x[-1], x_ref[-1])
        inside = (x >= begin) & (x <= end)
        if np.count_nonzero(inside) < 2:
            found = f"{x[0]:.6g} to {x[-1]:.6g} and {x_ref[0]:.6g} to {x_ref[-1]:.6g}"
            raise SceneError(
                f"compare: {column} over {self.abscissa} from {found}; expected rows of the first within the second"
            )
        return x[inside], y[inside], np.interp(x[inside], x_ref, y_ref)

    def _difference(self, column: str) -> Difference:
        positions, ours, theirs = self.on_both(column)
        x_ref, y_ref = self.reference.over(self.abscissa, column)
        inside = (x_ref >= positions[0]) & (x_ref <= positions[-1])
        largest = float(np.abs([*theirs, *y_ref[inside]]).max())
        off = ours - theirs
        scaled = off / largest if largest else np.where(off == 0, 0.0, math.inf)
        worst = int(np.abs(scaled).argmax())
        mean = float(np.sqrt(np.trapezoid(scaled**2, positions) / np.ptp(positions)))
        return Difference(column, largest, float(abs(scaled[worst])), float(positions[worst]), mean, float(scaled[-1]))

    def within(self, tolerance: float) -> bool:
        """Whether no column is further off than a tolerance anywhere."""
        return all(difference.worst <= tolerance for difference in self.differences)

    @property
    def cautions(self) -> list[str]:
        """What makes the figures less sure: rows of the reference far apart, or a part that only one of both has."""
        words = []
        x, x_ref = (curves.columns[self.abscissa] for curves in (self.history, self.reference))
        begin, end = float(np.fmax(np.nanmin(x), np.nanmin(x_ref))), float(np.fmin(np.nanmax(x), np.nanmax(x_ref)))
        widest = np.diff(np.clip(x_ref[np.isfinite(x_ref)], begin, end)).max() / (end - begin)
        if widest > COARSE:
            words.append(f"{self.reference.path}: straight over {100 * widest:.0f} % of what is compared")
        for path, positions in ((self.history.path, x), (self.reference.path, x_ref)):
            if (np.nanmax(positions) - end) + (begin - np.nanmin(positions)) > 1e-9 * (end - begin):
                words.append(f"{path}: only {begin:.6g} to {end:.6g} of its {self.abscissa} is compared")
        return words

    def table(self, tolerance: float) -> str:
        """The differences in words, as a Markdown table."""
        where = f"{self.abscissa} ({unit_of(self.abscissa)})"
        lines = [
            f"{self.history.path} against {self.reference.path}, over {self.abscissa}",
            "",
            f"| column | largest | off by at most | at {where} | root mean square | at the end | within |",
            "|---|---|---|---|---|---|---|",
        ]
        for d in self.differences:
            held = "yes" if d.worst <= tolerance else "no"
            lines.append(
                f"| {d.column} | {d.largest:.5g}{_shown(d.column)} | {_percent(d.worst)} | {d.where:.6g} "
                f"| {_percent(d.mean_square)} | {_percent(d.last)} | {held} |"
            )
        lines += ["", *(f"caution: {words}" for words in self.cautions)]
        verdict = "within" if self.within(tolerance) else "NOT within"
        return "\n".join([*lines, f"{verdict} {100 * tolerance:g} % of each column's largest size in the reference"])

    def draw(self, path: Path) -> None:
        """Draw each column of both, and their difference below."""
        across = min(len(self.columns), MOST_ACROSS)
        lines = math.ceil(len(self.columns) / across)
        figure = Figure(figsize=(4.2 * across + 1, 5 * lines + 0.5), layout="constrained")
        axes: Any = figure.subplots(2 * lines, across, height_ratios=[2, 1] * lines, squeeze=False)
        pairs = axes.reshape(lines, 2, across).swapaxes(1, 2).reshape(-1, 2)
        for above, below in pairs[len(self.columns) :]:
            above.remove()
            below.remove()
        for (above, below), difference in zip(pairs, self.differences, strict=False):
            self._draw_column(above, below, difference)
        figure.suptitle(f"{self.history.path}\nagainst {self.reference.path}", fontsize="medium")
        axes[0][0].legend()
        FigureCanvasAgg(figure).print_png(path)

    def _draw_column(self, above: Any, below: Any, difference: Difference) -> None:
        name = difference.column
        positions, ours, theirs = self.on_both(name)
        above.plot(*self.reference.over(self.abscissa, name), "k-", linewidth=2.5, alpha=0.4, label="reference")
        above.plot(*self.history.over(self.abscissa, name), "C0o", markersize=4, label="history")
        above.set(title=name, ylabel=f"{name} ({unit_of(name)})")
        below.plot(positions, 100 * (ours - theirs) / (difference.largest or 1.0), "C3.-", linewidth=1)
        below.set(xlabel=f"{self.abscissa} ({unit_of(self.abscissa)})", ylabel="difference (% of largest)")
        for here in (above, below):
            here.grid(alpha=0.3)


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if math.isfinite(share) else "not in the reference"


def _shown(column: str) -> str:
    unit = unit_of(column)
    return "" if unit == "1" else f" {unit}"
