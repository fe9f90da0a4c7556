"""Raw files of testing machines: encodings, separators, headings, units, several tests in a file."""

from __future__ import annotations

import codecs
import csv
import math
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.calibration.headings import QUANTITIES, Column, factor_of, is_unit, parts, plain, quantity_of
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import advice, parse_number

Floats = NDArray[np.float64]

MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
GROUPED = re.compile(r"[+-]?\d{1,3}(?:[.,]\d{3})+[.,]\d+")
"""A number whose groups of three digits have marks of their own: it is not sure which of both is the decimal one."""
MISSING = ("", "nan", "-", "--", "n/a")
LEAST_ROWS = 3


@dataclass(frozen=True)
class RawTest:
    """One test of a file.

    Attributes:
        path: of the file.
        number: of the test in it, from 1.
        lines: of its rows in the file, from 1.
        columns: values in SI by quantity.
        remarks: what stands before the heading, by its plain name: "specimen area" to "23104 mm2".
    """

    path: Path
    number: int
    lines: list[int]
    columns: dict[str, Floats]
    remarks: dict[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """For messages and legends."""
        return self.path.name if self.number == 1 else f"{self.path.name}, test {self.number}"


def read_tests(path: Path) -> list[RawTest]:
    """All tests of a file.

    Raises:
        SceneError: the file cannot be read, has no heading that is known, or a row of it is not of numbers; the row and
            the column are named.
    """
    separator, rows = _rows(path)
    tests: list[RawTest] = []
    remarks: dict[str, str] = {}
    at = 0
    while at < len(rows):
        line, cells = rows[at]
        columns, after = _heading(path, rows, at)
        if not columns:
            if tests and sum(_is_number(cell, separator) for cell in cells) > 1:
                raise SceneError(f"{path}: line {line} ({_shown(cells)}); expected the heading of another test")
            _remark(cells, remarks)
            at += 1
            continue
        at, block = _block(path, separator, rows, after, columns)
        if not block:
            raise SceneError(f"{path}: line {line}: a heading without numbers below it")
        for side in _sides(columns):
            tests += _split(path, block, side, RawTest(path, len(tests), [], {}, dict(remarks)))
    if not tests:
        raise SceneError(f"{path}: no heading with two known columns and their units, such as Time [s]; Force [N]")
    return tests


def _rows(path: Path) -> tuple[str, list[tuple[int, list[str]]]]:
    """What separates columns, and each row that is not empty with its line."""
    text = _decoded(path)
    lines = text.splitlines()
    counts = {mark: sum(line.count(mark) > 0 for line in lines) for mark in ("\t", ";", ",")}
    separator = next((mark for mark, count in counts.items() if count > len(lines) / 3), "")
    if not separator:
        raise SceneError(f"{path}: no tabs, semicolons or commas in most of its lines; expected columns apart by one")
    try:
        rows = [next(csv.reader([line], delimiter=separator), []) for line in lines]
    except csv.Error as error:
        raise SceneError(f"{path}: {error}; expected columns apart by {separator!r}") from error
    stripped = [(number, [cell.strip() for cell in cells]) for number, cells in enumerate(rows, 1)]
    return separator, [(number, cells) for number, cells in stripped if any(cells)]


def _decoded(path: Path) -> str:
    """Text of a file in UTF-8, UTF-16 or Windows-1252."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}; expected the file of a testing machine") from error
    encoding = next((name for mark, name in MARKS.items() if content.startswith(mark)), None)
    if encoding is None:
        zeros = [half.count(0) / max(len(half), 1) for half in (content[0::2], content[1::2])]
        encoding = "utf-16-be" if zeros[0] > 0.5 else "utf-16-le" if zeros[1] > 0.5 else "utf-8"
    try:
        return content.decode(encoding)
    except UnicodeDecodeError:
        pass
    try:
        return content.decode("cp1252")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: neither UTF-8, UTF-16 nor Windows-1252; expected a text file") from error


def _heading(path: Path, rows: list[tuple[int, list[str]]], at: int) -> tuple[list[Column], int]:
    """Columns that a row heads, none if it is no heading, and where its data begin."""
    line, cells = rows[at]
    if sum(parse_number(cell.replace(",", ".")) is not None for cell in cells) > 1:
        return [], at
    below = rows[at + 1][1] if at + 1 < len(rows) else []
    units_below = bool(below) and any(below) and all(is_unit(cell) for cell in below)
    found: list[Column] = []
    unknown = ""
    for number, cell in enumerate(cells):
        name, unit = parts(cell)
        if unit is None and units_below and number < len(below):
            unit = below[number].strip("[](){} ")
        quantity = quantity_of(name, unit) if cell else None
        if quantity is None:
            continue
        symbol = QUANTITIES[quantity][0]
        factor = factor_of(unit or "", symbol)
        if factor is None:
            unknown = unknown or f"column {cell!r}: no unit of {symbol}; expected one in brackets, or in a row of units"
        found.append(Column(number, cell, quantity, factor or 0.0))
    if len([column for column in found if column.quantity != "test"]) < 2:
        return [], at
    if unknown:
        raise SceneError(f"{path}: line {line}, {unknown}")
    return found, at + 1 + units_below


def _block(
    path: Path, separator: str, rows: list[tuple[int, list[str]]], at: int, columns: list[Column]
) -> tuple[int, list[tuple[int, list[float]]]]:
    """Where the data below a heading end, and their values in SI with their lines."""
    block: list[tuple[int, list[float]]] = []
    while at < len(rows):
        line, cells = rows[at]
        first = cells[columns[0].number] if columns[0].number < len(cells) else ""
        if block and not _is_number(first, separator):
            if _heading(path, rows, at)[0] or len([cell for cell in cells if cell]) < len(columns):
                break
            raise SceneError(f"{path}: line {line} ({_shown(cells)}); expected numbers, or the heading of another test")
        block.append((line, [_value(path, line, cells, column, separator) for column in columns]))
        at += 1
    return at, block


def _value(path: Path, line: int, cells: list[str], column: Column, separator: str) -> float:
    text = cells[column.number] if column.number < len(cells) else ""
    if column.quantity != "test" and text.lower() in MISSING:
        return math.nan
    if column.quantity == "test":
        digits = re.sub(r"\D", "", text)
        return float(digits) if digits else float(sum(text.encode()))
    number = None if GROUPED.fullmatch(text) else parse_number(_pointed(text, separator))
    if number is None:
        symbol = QUANTITIES[column.quantity][0]
        hint = advice(f"{text} {symbol}", symbol) or "; a decimal point or comma, and no marks between digits"
        raise SceneError(f"{path}: line {line}, column {column.heading!r} = {text!r}: expected a number{hint}")
    return column.factor * number


def _pointed(text: str, separator: str) -> str:
    return text if separator == "," else text.replace(",", ".")


def _is_number(text: str, separator: str) -> bool:
    return parse_number(_pointed(text, separator)) is not None


def _remark(cells: list[str], remarks: dict[str, str]) -> None:
    name, unit = parts(cells[0])
    if not name and unit is None:
        name, _, rest = cells[0].partition(":")
        cells = [name, rest, *cells[1:]]
    if ":" in name and len([cell for cell in cells if cell]) == 1:
        name, _, rest = cells[0].partition(":")
        cells, unit = [name, rest], None
    value = " ".join(cell for cell in cells[1:] if cell).strip()
    if name and value:
        remarks[plain(name).rstrip(":").strip()] = f"{value} {unit}" if unit else value


def _sides(columns: list[Column]) -> list[dict[str, int]]:
    """Places of the quantities of each test that stands beside others: where one comes again, the next test begins."""
    sides: list[dict[str, int]] = [{}]
    for place, column in enumerate(columns):
        if column.quantity in sides[-1]:
            sides.append({})
        sides[-1][column.quantity] = place
    return sides


def _split(path: Path, block: list[tuple[int, list[float]]], side: dict[str, int], before: RawTest) -> list[RawTest]:
    """Tests of a block: one, or one for each number in a column of tests."""
    lines, values = np.array([line for line, _ in block]), np.array([row for _, row in block])
    table = {quantity: values[:, place] for quantity, place in side.items()}
    marks = table.pop("test", np.zeros(len(block)))
    tests: list[RawTest] = []
    for mark in dict.fromkeys(marks.tolist()):
        columns = np.array([column[marks == mark] for column in table.values()])
        whole = np.isfinite(columns).all(axis=0)
        if np.count_nonzero(whole) < LEAST_ROWS:
            found = f"line {lines[0]}: {np.count_nonzero(whole)} rows of numbers in a test"
            raise SceneError(f"{path}: {found}; expected {LEAST_ROWS} or more")
        kept = dict(zip(table, columns[:, whole], strict=True))
        number = before.number + len(tests) + 1
        tests.append(replace(before, number=number, lines=lines[marks == mark][whole].tolist(), columns=kept))
    return tests


def _shown(cells: list[str]) -> str:
    text = ", ".join(cells)
    return text if len(text) <= 40 else text[:37] + "..."
