"""Which points a sweep runs: a full grid, a list, or a Latin hypercube. Points are made as they are asked for."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.scene.scene_file import decoded
from ncf_fenicsx.sweeps.inputs import Column, Input, Reader
from ncf_fenicsx.workers.rows import Point

HEADING = re.compile(r"(?P<key>[^\[\]]+?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")


@dataclass(frozen=True)
class Plan:
    """Points of a sweep.

    Attributes:
        columns: what a point has a value of.
        count: number of points.
        points: makes them, the same ones each time.
    """

    columns: tuple[Column, ...]
    count: int
    points: Callable[[], Iterator[Point]]

    @property
    def headings(self) -> list[str]:
        """Of the columns in a table."""
        return [column.heading for column in self.columns]


def grid(inputs: list[Input]) -> Plan:
    """All levels with all others.

    Raises:
        SceneError: an input is a range that does not say how many values.
    """
    for one in inputs:
        if not one.levels:
            name = one.name
            raise SceneError(f"--vary {name}: a grid needs the number of values; expected one, as in {name}=2..5 mm:4")
    return Plan(
        columns_of(inputs),
        math.prod(len(one.levels) for one in inputs),
        lambda: (join(parts) for parts in product(*(one.levels for one in inputs))),
    )


def latin(inputs: list[Input], count: int, seed: int) -> Plan:
    """Latin hypercube: each input has one point in each of as many equal slices as there are points (McKay 1979).

    Args:
        inputs: ranges are followed throughout; of levels each has its even share.
        count: number of points.
        seed: the same one gives the same points.
    """
    return shared(inputs, qmc.LatinHypercube(len(inputs), rng=seed).random(count))


def shared(inputs: list[Input], shares: NDArray[np.float64]) -> Plan:
    """Points at given shares, 0 to 1, of the inputs' ranges, shape (points, inputs)."""

    def points() -> Iterator[Point]:
        for row in shares:
            yield join(one.at(float(share)) for one, share in zip(inputs, row, strict=True))

    return Plan(columns_of(inputs), len(shares), points)


def listed(reader: Reader, path: Path) -> Plan:
    """Points of a CSV file whose heading has keys with units, as ``tool.radius [mm]``; a cell may have its own.

    Raises:
        SceneError: it cannot be read, or a row is no valid scene; its line is named.
    """
    lines = _lines(path)
    matches = [HEADING.fullmatch(cell.strip()) for cell in lines[0][1]]
    keys = [match["key"] if match else "" for match in matches]
    if not all(keys) or len(set(keys)) < len(keys):
        raise SceneError(f"{path}: expected a heading of different keys, as tool.radius [mm], and a row below it")
    units = [(match["unit"] or "").strip() if match else "" for match in matches]
    points: dict[Point, None] = {}
    columns: tuple[Column, ...] | None = None
    for number, cells in lines[1:]:
        try:
            if len(cells) != len(keys):
                raise SceneError(f"{len(cells)} cells; expected {len(keys)}")
            values = [_with_unit(cell.strip(), unit) for cell, unit in zip(cells, units, strict=True)]
            read = reader.columns(keys, values)
            if columns not in (None, read):
                raise SceneError("expected values of one kind in a column, all with units or all without")
        except SceneError as error:
            raise SceneError(f"{path}, line {number}: {error}") from error
        columns = read
        points[tuple(column.read(value) for column, value in zip(columns, values, strict=True))] = None
    if columns is None:
        raise SceneError(f"{path}: has no rows; expected one for each run")
    return Plan(columns, len(points), lambda: iter(points))


def columns_of(inputs: list[Input]) -> tuple[Column, ...]:
    """Columns of all inputs."""
    return tuple(column for one in inputs for column in one.columns)


def join(parts: Iterator[Point] | tuple[Point, ...]) -> Point:
    """One point of the values of each input."""
    return tuple(chain.from_iterable(parts))


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Rows that are not empty, with the numbers of their lines."""
    try:
        text = decoded(path, path.read_bytes())
    except OSError as error:
        raise SceneError(f"--list {path}: {error.strerror}; expected a CSV file") from error
    reader = csv.reader(text.splitlines())
    lines = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    if not lines:
        raise SceneError(f"--list {path}: is empty; expected a heading of keys, and a row below it")
    return lines


def _with_unit(cell: str, unit: str) -> str:
    """A cell with the unit of its heading, unless it has one of its own."""
    bare = unit and cell and cell[-1].isdigit()
    return f"{cell} {unit}" if bare else cell
