"""Options of the command line that studies on workers share."""

from __future__ import annotations

from typing import Annotated

import typer

Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Of a Dask scheduler that stands.")]
Cluster = Annotated[str | None, typer.Option(metavar="slurm|pbs|lsf", help="Runs as jobs of a batch system.")]
Workers = Annotated[
    int | None, typer.Option(help="Runs at a time; as many as cores and memory allow unless given.", min=1)
]
Ranks = Annotated[int, typer.Option(help="Processes of each run.", min=1)]
