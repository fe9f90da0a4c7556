"""How far the curves of ``laws.py`` are from each other."""

import numpy as np


class Worst:
    """Largest difference of dots from lines, relative to the largest value of each line."""

    def __init__(self) -> None:
        self.of: dict[str, float] = {}

    def note(self, name: str, computed: np.ndarray, exact: np.ndarray) -> None:
        """Compare two curves at the same places."""
        self.of[name] = float(np.abs(computed - exact).max() / np.abs(exact).max())
