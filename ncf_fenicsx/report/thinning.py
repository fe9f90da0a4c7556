"""Which of many things are shown where all of them would be too many."""

from __future__ import annotations

import numpy as np


def evenly(count: int, most: int) -> list[int]:
    """Numbers of at most so many of a count of things, the first and the last among them."""
    return sorted({int(number) for number in np.linspace(0, count - 1, min(count, most)).round()})
