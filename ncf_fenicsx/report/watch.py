"""A run that goes on in another terminal, watched by its results folder."""

from __future__ import annotations

import time
from pathlib import Path

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.numbers import ending
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import short

LAST = 12
"""Steps that are shown."""
SHOWN = (
    ("time", "time, s", 1.0),
    ("time_step", "step, s", 1.0),
    ("tool_force", "force, N", 1.0),
    ("vf_max", "largest Vf", 1.0),
    ("pressure_max", "pressure, kPa", 1e-3),
    ("contact_width", "contact along x, mm", 1e3),
    ("contact_length", "along y, mm", 1e3),
    ("newton_iterations", "iterations", 1.0),
    ("step_cuts", "cuts", 1.0),
    ("wall_time", "run time, s", 1.0),
)
"""Columns of the history with their headings and factors from SI."""


def watch(folder: Path, every: float, console: Console | None = None) -> None:
    """Show the last steps of a run until it has ended.

    Args:
        folder: of its results.
        every: seconds between two looks.
        console: where it is shown; standard output unless given.

    Raises:
        SceneError: it is no results folder.
    """
    if not folder.is_dir():
        raise SceneError(f"{folder}: no such folder; expected a results folder")
    console = console or Console()
    if _read(folder) is None:
        console.print(Text(f"waiting for a run in {folder}"))
    with Live(console=console, auto_refresh=False) as live:
        while True:
            results = _read(folder)
            if results is not None:
                live.update(steps(results), refresh=True)
                if results.record:
                    return
            time.sleep(every)


def _read(folder: Path) -> Results | None:
    """The results so far; None where a run has only begun."""
    return Results.read(folder) if (folder / "scene.toml").exists() else None


def steps(results: Results) -> Table:
    """Table of the last steps."""
    shown = [column for column in SHOWN if column[0] in results.history]
    table = Table(title=Text(results.scene.title), caption=Text(ending(results)))
    for _, heading, _ in shown:
        table.add_column(heading, justify="right")
    for row in range(max(results.rows - LAST, 0), results.rows):
        table.add_row(*(short(factor * float(results.history[name][row])) for name, _, factor in shown))
    return table
