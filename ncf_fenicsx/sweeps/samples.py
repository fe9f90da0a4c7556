"""Rows of a study as numbers: inputs and one result of the runs that are done."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.sweeps.inputs import Input
from ncf_fenicsx.workers.engine import ENDING
from ncf_fenicsx.workers.rows import Point, read_rows

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Points and what they came to.

    Attributes:
        points: values of all columns, one tuple a run.
        values: of each result by its heading, NaN where a run is not done or has none, shape (runs,).
        endings: how many runs ended in each way.
    """

    points: list[Point]
    values: dict[str, Floats]
    endings: dict[str, int]

    @classmethod
    def read(cls, path: Path, columns: list[str], headings: list[str]) -> Samples:
        """Read a file of rows.

        Args:
            path: of the file.
            columns: headings of the inputs.
            headings: of the results.
        """
        points, cells, endings = [], [], Counter[str]()
        for row in read_rows(path):
            points.append(tuple(row[column] for column in columns))
            cells.append([float(row[heading] or "nan") for heading in headings])
            endings[row[ENDING]] += 1
        table = np.array(cells).reshape(len(cells), len(headings))
        return cls(points, {heading: table[:, number] for number, heading in enumerate(headings)}, dict(endings))

    def of(self, inputs: list[Input]) -> list[list[Point]]:
        """Values of each input, which may have several columns, one a run."""
        parts, start = [], 0
        for one in inputs:
            end = start + len(one.columns)
            parts.append([point[start:end] for point in self.points])
            start = end
        return parts

    def at(self, points: list[Point], heading: str) -> Floats:
        """A result at points in their order, NaN where a run has none."""
        known = dict(zip(self.points, self.values[heading], strict=True))
        return np.array([known[point] for point in points])

    def varies(self, heading: str) -> bool:
        """Whether a result differs between runs by more than round-off."""
        values = self.values[heading][np.isfinite(self.values[heading])]
        return len(values) > 1 and bool(np.ptp(values) > 1e-9 * np.abs(values).max())

    @property
    def in_words(self) -> str:
        """How the runs ended."""
        return f"{len(self.points)} runs: " + ", ".join(f"{count} {ending}" for ending, count in self.endings.items())
