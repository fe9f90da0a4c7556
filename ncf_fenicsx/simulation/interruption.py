"""Why a run ends before its time: Ctrl-C, SIGTERM, its deadline, its own judgement; heard at the next iteration."""

from __future__ import annotations

import math
import signal
import time
from types import FrameType, TracebackType
from typing import Any, Self

from mpi4py import MPI

SIGNALS: dict[int, signal.Signals] = {
    signal.SIGINT: signal.SIGINT,
    signal.SIGTERM: signal.SIGTERM,
    signal.SIGUSR1: signal.SIGINT,
    signal.SIGUSR2: signal.SIGTERM,
}
"""Signals that end a run, with what was meant: a launcher passes the last two on to its ranks, but not the first."""
INTERRUPTED = "interrupted"
TIME_IS_UP = "its time is up"
LATE = signal.NSIG
"""Stands among the signals for a deadline that has passed."""


class Interruption:
    """Whether a run has been asked to end, on any rank; a second signal ends the program at once.

    Args:
        comm: ranks of the run.
        deadline: by the monotonic clock in s.

    Attributes:
        request: in words, why the run itself asks to end, the same on all ranks; None while it does not.
    """

    def __init__(self, comm: MPI.Comm, deadline: float = math.inf) -> None:
        self.comm, self._deadline = comm, deadline
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
        self._received = SIGNALS[number]

    def reason(self) -> str | None:
        """In words, why to end; None to go on. Collective."""
        late = LATE if time.monotonic() > self._deadline else 0
        number = self.comm.allreduce(max(self._received, late), MPI.MAX)
        if number == LATE:
            return TIME_IS_UP
        return f"{INTERRUPTED} by {signal.Signals(number).name}" if number else self.request


def was_asked_to_end(reason: str) -> bool:
    """Whether a run ended for such a reason because someone asked for it, or its time was up."""
    return INTERRUPTED in reason or TIME_IS_UP in reason
