"""What is drawn when all results are on the disk: none of it may cost a result, or end a program with an error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from ncf_fenicsx.report.page import PAGE, write_report
from ncf_fenicsx.scene.settings import Output

LONGEST = 200
"""Letters of an error's message that are told."""

Drawing = Callable[[Path], object]


def drawings_of_run(output: Output) -> dict[str, Drawing]:
    """What makes the files that a scene asks for, by the files' names."""
    drawings: dict[str, Drawing] = {"summary.png": _draw_summary} if output.picture else {}
    return drawings | ({PAGE: write_report} if output.report else {})


def _draw_summary(folder: Path) -> object:
    from ncf_fenicsx.report.summary_picture import draw_summary  # Matplotlib takes as long to load as a small scene

    return draw_summary(folder)


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
