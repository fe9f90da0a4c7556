"""What ranks do together: work of one rank whose failure is everyone's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from mpi4py import MPI

Result = TypeVar("Result")


def on_root(comm: MPI.Comm, work: Callable[[], Result]) -> Result:
    """Result of ``work``, done on rank 0 only and sent to all; what it raises, every rank raises."""
    result: Result | None = None
    error: Exception | None = None
    if comm.rank == 0:
        try:
            result = work()
        except Exception as caught:
            error = caught
    error = comm.bcast(error)
    if error is not None:
        raise error
    return comm.bcast(result)


def gather_rows(comm: MPI.Comm, rows: np.ndarray) -> np.ndarray | None:
    """Rows of all ranks, one below the other, on rank 0; None elsewhere."""
    parts: list[Any] | None = comm.gather(rows)
    return None if parts is None else np.concatenate(parts)
