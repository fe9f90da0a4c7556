"""What is drawn when all results are on the disk: none of it may cost a result, or end a program with an error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

LONGEST = 200
"""Letters of an error's message that are told."""

Drawing = Callable[[Path], object]


def drawn_or_told(folder: Path, drawings: Mapping[str, Drawing]) -> list[str]:
    """Make each file of a folder, whatever becomes of the others; what could not be made, a line for each.

    Args:
        folder: with all results.
        drawings: what makes a file of the folder, by the file's name.
    """
    told = []
    for name, draw in drawings.items():
        try:
            draw(folder)
        except Exception as error:
            told.append(f"no {name}: {_in_a_line(error)}; the results are complete without it")
    return told


def _in_a_line(error: Exception) -> str:
    words = " ".join(f"{type(error).__name__}: {error}".split())
    return words if len(words) <= LONGEST else f"{words[:LONGEST]}..."
