"""Why a run ends before its time: Ctrl-C, SIGTERM, or its own judgement; heard at the next Newton iteration."""

from __future__ import annotations

import signal
from types import FrameType, TracebackType
from typing import Any, Self

from mpi4py import MPI

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interruption:
    """Whether a run has been asked to end, on any rank; a second signal ends the program at once.

    Args:
        comm: ranks of the run.

    Attributes:
        request: in words, why the run itself asks to end, the same on all ranks; None while it does not.
    """

    def __init__(self, comm: MPI.Comm) -> None:
        self.comm = comm
        self.request: str | None = None
        self._received = 0
        self._old: dict[int, Any] = {}

    def __enter__(self) -> Self:
        self._old = {number: signal.signal(number, self._receive) for number in SIGNALS}
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        del kind, error, trace
        for number, handler in self._old.items():
            signal.signal(number, handler)

    def _receive(self, number: int, frame: FrameType | None) -> None:
        del frame
        if self._received:
            raise KeyboardInterrupt
        self._received = number

    def reason(self) -> str | None:
        """In words, why to end; None to go on. Collective."""
        number = self.comm.allreduce(self._received, MPI.MAX)
        return f"interrupted by {signal.Signals(number).name}" if number else self.request
