"""What writers of files have in common: a file is a function that writes it, called when all of them are made."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Writer = Callable[[Path], None]


def rows_of(table: NDArray[Any]) -> list[Any]:
    """Rows of an array as Python's numbers."""
    return list(table.tolist())


def text_writer(lines: list[str]) -> Writer:
    """What writes lines of text."""

    def write(path: Path) -> None:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    return write


def classes(values: Floats, most: int) -> Integers:
    """Number of the class that each value lies in, from 0: at most so many of equal width, each with a value in it.

    Values that differ by round-off alone are one class.
    """
    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-9 * abs(high):
        return np.zeros(len(values), dtype=np.int64)
    width = (high - low) / most
    found = np.minimum(((values - low) / width).astype(np.int64), most - 1)
    return np.asarray(np.unique(found, return_inverse=True)[1], dtype=np.int64)
