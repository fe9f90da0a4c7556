"""Inputs of a sweep in SI, each read by the scene itself: a wrong key, value or unit is refused before a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import parse_number, parse_quantity
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.sweeps.ranges import Vary, split_unit
from ncf_fenicsx.workers.rows import Point

DIGITS = 12
"""Digits of a value that a plan has chosen: what a row says is what is run."""


@dataclass(frozen=True)
class Column:
    """A key of the scene that a sweep varies.

    Attributes:
        key: of the scene.
        unit: SI unit of its values; empty of numbers and words without any.
        whole: whether it is a whole number.
    """

    key: str
    unit: str = ""
    whole: bool = False

    @property
    def heading(self) -> str:
        """Of its column, as ``tool.radius [m]``."""
        return f"{self.key} [{self.unit}]" if self.unit else self.key

    def override(self, value: str) -> str:
        """What ``--set`` takes to give the key a value in SI."""
        return f"{self.key}={value} {self.unit}".rstrip()

    def text(self, value: float) -> str:
        """A value in SI as the rows have it."""
        if self.whole:
            return str(round(value))
        return repr(float(f"{value:.{DIGITS}g}"))

    def read(self, text: str) -> str:
        """A value of a scene file in SI; what is no quantity stays as it is."""
        number = parse_quantity(text, self.unit) if self.unit else parse_number(text)
        return text if number is None else self.text(number)


@dataclass(frozen=True)
class Input:
    """Columns that change together.

    Attributes:
        columns: as many as keys are tied together.
        levels: values of the columns; of a range those that it asks for.
        ends: lowest and highest value of a range in SI.
        logarithmic: whether a range is even in the logarithm.
    """

    columns: tuple[Column, ...]
    levels: tuple[Point, ...] = ()
    ends: tuple[float, float] | None = None
    logarithmic: bool = False

    @property
    def name(self) -> str:
        """In words."""
        return " and ".join(column.key for column in self.columns)

    def at(self, share: float) -> Point:
        """Values at a share of the range, 0 to 1; of levels the one that the share falls on."""
        if self.ends is None:
            return self.levels[min(int(share * len(self.levels)), len(self.levels) - 1)]
        low, high = self.ends
        value = low * (high / low) ** share if self.logarithmic else low + (high - low) * share
        return tuple(column.text(value) for column in self.columns)


class Reader:
    """Reads values as the scene does.

    Args:
        file: of the scene.
        overrides: ``key=value`` texts for all runs.
    """

    def __init__(self, file: Path, overrides: Sequence[str]) -> None:
        self.file, self.overrides = file, tuple(overrides)

    def check(self, columns: Sequence[Column], point: Point) -> None:
        """Whether a point is a valid scene.

        Raises:
            SceneError: it is none.
        """
        self._scene([column.override(value) for column, value in zip(columns, point, strict=True)])

    def columns(self, keys: Sequence[str], values: Sequence[str]) -> tuple[Column, ...]:
        """Columns of keys, with the units of these values.

        Raises:
            SceneError: a key or a value is not valid.
        """
        table = self._scene([f"{key}={value}" for key, value in zip(keys, values, strict=True)]).table()
        return tuple(_column(table, key, value) for key, value in zip(keys, values, strict=True))

    def unit(self, key: str) -> str:
        """SI unit of what the scene has at a key; empty of numbers and words without any.

        Raises:
            SceneError: the scene has nothing there.
        """
        found = _at(self._scene([]).table(), key)
        if found is None:
            raise SceneError(
                f"{self.file}: {key}: not in the scene; expected a key that it has, such as stack.thickness"
            )
        quantity = split_unit(found) if isinstance(found, str) else None
        return quantity[1] if quantity else ""

    def input(self, vary: Vary) -> Input:
        """What is varied, in SI; each value and both ends of a range make a valid scene.

        Raises:
            SceneError: a key or a value is not valid, or a range is empty.
        """
        if vary.ends is None:
            columns = self.columns(vary.keys, vary.values[0])
            for values in vary.values[1:]:
                if self.columns(vary.keys, values) != columns:
                    raise SceneError(f"--vary {vary.text}: expected values of one kind, all with units or all without")
            levels = tuple(_read(columns, values) for values in vary.values)
            if len(set(levels)) < len(levels):
                raise SceneError(f"--vary {vary.text}: expected each value once")
            return Input(columns, levels)
        return self._range(vary, vary.ends)

    def _range(self, vary: Vary, texts: tuple[str, str]) -> Input:
        columns, *others = (self.columns(vary.keys, [text] * len(vary.keys)) for text in texts)
        first, last = (_read(columns, [text] * len(columns)) for text in texts)
        low, high = parse_number(first[0]), parse_number(last[0])
        if others[0] != columns or len({column.unit for column in columns}) > 1 or low is None or high is None:
            raise SceneError(f"--vary {vary.text}: expected numbers with one unit at both ends of a range")
        if not low < high or (vary.logarithmic and low <= 0):
            least = "a positive lower end below the upper" if vary.logarithmic else "a lower end below the upper"
            raise SceneError(f"--vary {vary.text}: empty range; expected {least}")
        whole = Input(columns, (), (low, high), vary.logarithmic)
        shares = np.linspace(0.0, 1.0, vary.count or 0)
        levels = tuple(dict.fromkeys(whole.at(float(share)) for share in shares))
        if len(levels) < (vary.count or 0):
            raise SceneError(f"--vary {vary.text}: has {len(levels)} whole numbers; expected that many values at most")
        return Input(columns, levels, (low, high), vary.logarithmic)

    def _scene(self, texts: list[str]) -> Scene:
        return Scene.read(self.file, (*self.overrides, *texts))


def read_inputs(reader: Reader, varied: Sequence[Vary]) -> list[Input]:
    """All inputs of a sweep.

    Raises:
        SceneError: a key or a value is not valid, or a key is varied twice.
    """
    keys = [key for vary in varied for key in vary.keys]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise SceneError(f"--vary {twice}: varied twice; expected each key once")
    return [reader.input(vary) for vary in varied]


def _read(columns: Sequence[Column], values: Sequence[str]) -> Point:
    return tuple(column.read(value) for column, value in zip(columns, values, strict=True))


def _column(table: dict[str, Any], key: str, value: str) -> Column:
    """A column with the unit that the scene, all filled in, gives the key."""
    found = _at(table, key)
    quantity = split_unit(found) if isinstance(found, str) else None
    if quantity is not None and quantity[1] and parse_quantity(value, quantity[1]) is not None:
        return Column(key, quantity[1])
    return Column(key, whole=isinstance(found, int) and not isinstance(found, bool))


def _at(table: Any, key: str) -> Any:
    """What a table has at a dotted key; None where it has nothing. A list of one may stand as that one."""
    for name in key.split("."):
        if isinstance(table, list):
            number = int(name) if name.isdecimal() else -1
            table = table[number] if 0 <= number < len(table) else None
        elif isinstance(table, dict):
            table = table if name == "0" and name not in table else table.get(name)
        else:
            return None
    return table


def number_of(text: str) -> float:
    """A value of a point as a number; NaN of a word."""
    number = parse_number(text)
    return math.nan if number is None else number
