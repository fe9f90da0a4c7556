"""Histories read back, of this program or of another: columns over time, in SI, their units checked."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.measures import COLUMNS
from ncf_fenicsx.units import parse_quantity

Floats = NDArray[np.float64]

HEADING = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(\[(?P<unit>[^\[\]]*)\])?\s*")
NUMBER = re.compile(r"(_layer)?_\d+$")


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
    def read(cls, path: Path) -> Curves:
        """History from a CSV file with a heading: names as in ``history.csv``, in SI, or with a unit: ``force [kN]``.

        Columns that ``history.csv`` does not have are left out.

        Raises:
            SceneError: the file cannot be read, or a unit or value in it is not valid.
        """
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                heading, *rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)] or [[]]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            reason = getattr(error, "strerror", None) or error
            raise SceneError(f"{path}: {reason}; expected a history as CSV") from error
        columns = {}
        for number, text in enumerate(heading):
            name, factor = _column(path, text)
            if name in columns:
                raise SceneError(f"{path}: column {name} is there twice; expected once")
            if factor is not None:
                columns[name] = factor * np.array([_value(path, name, row, number) for row in rows])
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
    factor = parse_quantity(f"1 {unit}", wanted)
    if factor is None:
        raise SceneError(f"{path}: column {name} in {unit!r}; expected a unit of {wanted}")
    return name, factor


def _value(path: Path, name: str, row: list[str], number: int) -> float:
    text = row[number].strip() if number < len(row) else ""
    try:
        return float(text) if text else float("nan")
    except ValueError:
        raise SceneError(f"{path}: {name} = {text!r}; expected a number") from None
