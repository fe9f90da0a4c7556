"""Inputs with distributions: one key by a text, or the numbers of a calibration together, by their covariance.

================================  ==========================================================================
text                              distribution
================================  ==========================================================================
``key=normal(1 MPa, 0.1 MPa)``    normal, by mean and standard deviation
``key=normal(1 MPa, 10 %)``       the same, the deviation as a share of the mean
``key=lognormal(1 MPa, 1.2)``     logarithm normal, by median and the factor of one standard deviation
``key=uniform(1 mm, 2 mm)``       uniform, by its ends
``key=triangular(1, 1.5, 3 mm)``  triangular, by lower end, peak and upper end
================================  ==========================================================================

A number without a unit has that of the last.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import parse_number
from ncf_fenicsx.scene.fabric_file import read_fabric
from ncf_fenicsx.sweeps.germs import Germ
from ncf_fenicsx.sweeps.inputs import Column, Reader
from ncf_fenicsx.sweeps.ranges import split, split_unit
from ncf_fenicsx.workers.rows import Point

Floats = NDArray[np.float64]
TEXT = re.compile(r"(?P<key>[^=]+)=\s*(?P<kind>\w+)\((?P<numbers>.*)\)\s*")
COUNTS = {"normal": 2, "lognormal": 2, "uniform": 2, "triangular": 3}
"""Numbers of each kind."""
FAR = 2.0
"""Standard deviations up to which values have to make a valid scene."""


@dataclass(frozen=True)
class Uncertain:
    """Columns with a joint distribution.

    Attributes:
        columns: keys of the scene.
        kind: one of `COUNTS`, or ``joint``.
        numbers: of the kind in SI; means of a joint one.
        factor: of the covariance, lower triangle (Cholesky), of a joint one.
    """

    columns: tuple[Column, ...]
    kind: str
    numbers: tuple[float, ...]
    factor: tuple[tuple[float, ...], ...] = ()

    @property
    def germs(self) -> list[Germ]:
        """Independent variables that the values are made of."""
        return ["share" if self.kind in ("uniform", "triangular") else "normal"] * len(self.columns)

    @property
    def name(self) -> str:
        """In words."""
        return " and ".join(column.key for column in self.columns)

    def at(self, germs: Sequence[float]) -> Point:
        """Values in SI."""
        if self.kind == "joint":
            values = [float(value) for value in np.array(self.numbers) + np.array(self.factor) @ np.array(germs)]
        else:
            values = [_value(self.kind, self.numbers, germs[0])]
        return tuple(column.text(value) for column, value in zip(self.columns, values, strict=True))


def parse_uncertain(reader: Reader, text: str) -> Uncertain:
    """Read one of the texts above.

    Raises:
        SceneError: it is none, or its values make no valid scene.
    """
    match = TEXT.fullmatch(text)
    if match is None or match["kind"] not in COUNTS:
        kinds = ", ".join(COUNTS)
        raise SceneError(
            f"--vary {text}: expected KEY=KIND(NUMBERS), as laws.shear.modulus=normal(1 MPa, 10 %): {kinds}"
        )
    key, kind, texts = match["key"].strip(), match["kind"], split(match["numbers"])
    if len(texts) != COUNTS[kind]:
        raise SceneError(f"--vary {text}: {len(texts)} numbers; expected {COUNTS[kind]} of {kind}")
    (column,) = reader.columns([key], [_with_unit(texts[0], texts[-1])])
    made = Uncertain((column,), kind, _numbers(text, kind, column, texts))
    _check(reader, made, f"--vary {text}")
    return made


def of_fit(reader: Reader, path: Path) -> Uncertain:
    """Fitted numbers of a fabric's laws as a calibration has left them: normal, with their covariance.

    What was fitted of the machine is no input of a scene; the others keep their own variances.

    Raises:
        SceneError: the fabric has no fit, or its numbers make no valid scene.
    """
    fit = read_fabric(path).get("fit")
    kept = [] if fit is None else [n for n, name in enumerate(fit["names"]) if not name.startswith("machine.")]
    if fit is None or not kept:
        raise SceneError(f"--fit {path}: has no fitted numbers; expected a fabric of ncf-fenicsx calibrate")
    covariance = np.array(fit["covariance"])[np.ix_(kept, kept)]
    try:
        factor = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError as error:
        raise SceneError(f"--fit {path}: fit.covariance: expected a positive definite matrix") from error
    keys = [f"laws.{fit['names'][number]}" for number in kept]
    columns = tuple(Column(key, reader.unit(key)) for key in keys)
    means = tuple(float(fit["values"][number]) for number in kept)
    made = Uncertain(columns, "joint", means, tuple(tuple(float(one) for one in row) for row in factor))
    _check(reader, made, f"--fit {path}")
    return made


def _numbers(text: str, kind: str, column: Column, texts: list[str]) -> tuple[float, ...]:
    """Numbers of a kind in SI."""
    read = [parse_number(column.read(_with_unit(one, texts[-1]))) for one in texts]
    last = split_unit(texts[-1])
    if kind == "normal" and last is not None and last[1] == "%" and read[0] is not None:
        read[1] = abs(read[0]) * float(last[0]) / 100
    if kind == "lognormal":
        read[1] = parse_number(texts[1])
    numbers = [math.nan if number is None else number for number in read]
    fits = {
        "normal": lambda: numbers[1] > 0,
        "lognormal": lambda: numbers[0] > 0 and numbers[1] > 1,
        "uniform": lambda: numbers[0] < numbers[1],
        "triangular": lambda: numbers[0] <= numbers[1] <= numbers[2] and numbers[0] < numbers[2],
    }
    if not fits[kind]():
        expected = {
            "normal": "a mean, and a deviation above 0 in its unit or in %",
            "lognormal": "a positive median, and a factor above 1",
            "uniform": "a lower end below the upper, in one unit",
            "triangular": "lower end, peak and upper end in their order, in one unit",
        }
        raise SceneError(f"--vary {text}: expected {expected[kind]}")
    return tuple(numbers)


def _with_unit(text: str, last: str) -> str:
    """A number with the unit of the last one, unless it has its own."""
    unit = split_unit(last)
    bare = unit is not None and unit[1] not in ("", "%") and parse_number(text) is not None
    return f"{text} {unit[1]}" if bare and unit else text


def _value(kind: str, numbers: Sequence[float], germ: float) -> float:
    """Value of a distribution at its germ."""
    if kind == "normal":
        return numbers[0] + numbers[1] * germ
    if kind == "lognormal":
        return float(numbers[0] * numbers[1] ** germ)
    if kind == "uniform":
        return numbers[0] + (numbers[1] - numbers[0]) * germ
    low, peak, high = numbers
    if germ * (high - low) <= peak - low:
        return low + math.sqrt(germ * (high - low) * (peak - low))
    return high - math.sqrt((1 - germ) * (high - low) * (high - peak))


def _check(reader: Reader, made: Uncertain, text: str) -> None:
    """Whether values at the middle and far from it make a valid scene."""
    for side in (-1, 0, 1):
        germs = [side * FAR if germ == "normal" else (1 + side) / 2 for germ in made.germs]
        try:
            reader.check(made.columns, made.at(germs))
        except SceneError as error:
            where = f", {FAR:g} standard deviations from the middle" if side and "normal" in made.germs else ""
            raise SceneError(f"{text}{where}: {error}") from error
