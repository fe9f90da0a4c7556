"""What errors are measured against: values extrapolated from refinements, and the field of the finest one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.grid_lines import grid_lines
from ncf_fenicsx.report.reading import read_fields, read_snapshots

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST_ORDER = 3
"""Observed order above which values have met by chance: no method here has more than 2."""


@dataclass(frozen=True)
class Extrapolated:
    """Limit of a value under refinement (Richardson 1911).

    Attributes:
        value: the limit.
        order: observed order of convergence; NaN where the values do not converge evenly, the finest one being taken.
        uncertainty: how far the limit is off the finest value.
    """

    value: float
    order: float
    uncertainty: float

    @classmethod
    def of(cls, coarse: float, middle: float, fine: float) -> Extrapolated:
        """Limit of the values of three refinements by two."""
        first, second = middle - coarse, fine - middle
        if not second or not 1 < first / second <= 2**MOST_ORDER:
            return cls(fine, math.nan, abs(second))
        ratio = first / second
        limit = fine + second / (ratio - 1)
        return cls(limit, math.log2(ratio), abs(limit - fine))


class VfField:
    """Vf by cell at the end of a run, of a stack extruded from a grid.

    Args:
        folder: of the run.
    """

    def __init__(self, folder: Path) -> None:
        mesh = read_fields(folder / read_snapshots(folder)[-1][1])
        cells = mesh.cells_dict["hexahedron"]
        corners = mesh.points[cells]
        self.low, self.high = corners.min(axis=1), corners.max(axis=1)
        self.extent = float(np.ptp(mesh.points, axis=0).max())
        self.values: Floats = mesh.cell_data_dict["volume_fraction"]["hexahedron"]

    @property
    def volumes(self) -> Floats:
        """Undeformed volumes of the cells in m3."""
        volumes: Floats = np.prod(self.high - self.low, axis=1)
        return volumes

    def at(self, positions: Floats) -> Floats:
        """Vf at undeformed positions in m, shape (positions, 3): that of the cell which holds each."""
        counts = []
        index: Integers = np.zeros(len(self.values), dtype=np.int64)
        where: Integers = np.zeros(len(positions), dtype=np.int64)
        for axis in range(3):
            edges, number = grid_lines(self.low[:, axis], self.extent)
            counts.append(len(edges))
            index = index * len(edges) + number
            inside = np.searchsorted(edges, positions[:, axis], side="right") - 1
            where = where * len(edges) + np.clip(inside, 0, len(edges) - 1)
        ordered = np.full(math.prod(counts), np.nan)
        ordered[index] = self.values
        return np.asarray(ordered[where])

    def change(self, rest: float) -> float:
        """Root mean square of its change from the Vf at rest."""
        return float(np.sqrt(self.volumes @ (self.values - rest) ** 2 / self.volumes.sum()))

    def off(self, reference: VfField, rest: float) -> float:
        """Root mean square difference from a finer field, over that of its change from the Vf at rest."""
        difference = self.at(0.5 * (reference.low + reference.high)) - reference.values
        return float(np.sqrt(reference.volumes @ difference**2 / reference.volumes.sum()) / reference.change(rest))
