"""What a command says: on rank 0, in letters that the terminal has."""

from __future__ import annotations

import codecs
import sys
from io import TextIOWrapper


def say(text: str) -> None:
    """Print on rank 0."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank == 0:
        print(text, flush=True)


def complain(message: str) -> None:
    """Print one line on standard error, on rank 0."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank == 0:
        print("ncf-fenicsx: " + " ".join(message.split()), file=sys.stderr, flush=True)


def write_any_text() -> None:
    """Let the streams take every letter: UTF-8 where the locale is mere ASCII, else escapes for what it has not."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            encoding = codecs.lookup(stream.encoding).name
            stream.reconfigure(encoding="utf-8" if encoding == "ascii" else encoding, errors="backslashreplace")
