"""What a run shows while it goes: a bar on a terminal, one line a step elsewhere."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from types import TracebackType
from typing import Self

from mpi4py import MPI
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

LAUNCHERS = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}
"""Variables that Open MPI's and MPICH's launchers set."""


class ProgressBar:
    """Progress towards the end of a path.

    Args:
        duration: time at the end in s.
        comm: ranks of the run; rank 0 shows, and a bar only without mpirun, which puts its output on a terminal
            of its own even if it ends in a file.
        bars: error bars of columns of the history, over their size, that are known beforehand.

    Attributes:
        cautions: what a user has been told to mind, for the record of the run.
    """

    def __init__(self, duration: float, comm: MPI.Comm, bars: Mapping[str, float] | None = None) -> None:
        self.visible, self._bars = comm.rank == 0, bars or {}
        self.cautions: list[str] = []
        self.bar: Progress | None = None
        if comm.size == 1 and sys.stdout.isatty() and not LAUNCHERS & set(os.environ):
            columns = (BarColumn(bar_width=12), TextColumn("{task.description}"), TimeElapsedColumn())
            self.bar = Progress(*columns, console=Console())
            self._task = self.bar.add_task("first solve", total=duration)

    def __enter__(self) -> Self:
        if self.bar is not None:
            self.bar.start()
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        del kind, error, trace
        if self.bar is not None:
            self.bar.stop()

    def note(self, text: str) -> None:
        """Say what goes on before the first step."""
        if self.visible:
            print(text, flush=True)

    def caution(self, text: str) -> None:
        """Say once what a user has to mind, and keep it."""
        if text not in self.cautions:
            self.cautions.append(text)
            self.note(f"caution: {text}")

    def show(self, row: dict[str, float]) -> None:
        """Show an accepted step."""
        text = f"{row['time']:9.3f} s  step {row['time_step']:7.3g} s"
        if "newton_iterations" in row:
            text += f"  {row['newton_iterations']:2.0f} iterations"
        if "kinetic_share" in row:
            text += f"  {row['explicit_steps']:.0f} steps  kinetic {100 * row['kinetic_share']:.2g} %"
        if "tool_force" in row:
            text += f"  {row['tool_force']:10.4g} N{self._bar('tool_force')}"
        if "vf_max" in row:
            text += f"  Vf max {row['vf_max']:.4f}{self._bar('vf_max')}"
        if self.bar is not None:
            self.bar.update(self._task, completed=row["time"], description=" ".join(text.split()))
        elif self.visible:
            print(text, flush=True)

    def _bar(self, column: str) -> str:
        return f" +- {100 * self._bars[column]:.2g} %" if column in self._bars else ""
