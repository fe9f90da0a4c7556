"""Arrays as short text inside a page: whole numbers, differences, bytes sorted by significance, deflate, base64.

The page's own ``decode.js`` undoes it. Steps in time resemble each other, so what is kept of them is how they differ.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEVELS = 65535
"""Largest whole number that a value of a field becomes: its range is told in that many steps."""

Encoded = dict[str, Any]


def series(values: NDArray[Any]) -> Encoded:
    """A field at all steps, rounded to `LEVELS` steps of its range.

    Args:
        values: finite, shape (steps, places).

    Returns:
        ``low`` and ``step`` such that a value is low + step * whole number, the shape, and the numbers as text.
    """
    low, high = float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))
    step = (high - low) / LEVELS if high > low else 0.0
    whole: NDArray[Any] = np.empty(values.shape, np.uint16)
    for row, of_step in zip(whole, values, strict=True):
        row[:] = np.round((of_step.astype(np.float64) - low) / (step or 1.0))
    whole[1:] -= whole[:-1].copy()
    return {"low": low, "step": step, "shape": list(values.shape), "data": _packed(whole)}


def table(values: NDArray[Any]) -> Encoded:
    """Whole numbers of 32 bits, shape (rows, columns), exactly."""
    rows = values.astype(np.int32)
    rows[1:] -= rows[:-1].copy()
    return {"shape": list(values.shape), "data": _packed(rows)}


def numbers(values: NDArray[Any]) -> Encoded:
    """Numbers of 32 or 64 bits, exactly; of any shape."""
    return {"shape": list(values.shape), "bits": 8 * values.dtype.itemsize, "data": _packed(values)}


def _packed(values: NDArray[Any]) -> str:
    """Little-endian bytes, the first of all values before the second of all, as text."""
    little = values.astype(values.dtype.newbyteorder("<"))
    planes = np.ascontiguousarray(little).reshape(-1, 1).view(np.uint8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode("ascii")
