"""Hands runs to workers, a few at a time, and takes what they come to as it comes."""

from __future__ import annotations

from asyncio import CancelledError
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from distributed import wait
from distributed.scheduler import KilledWorker
from rich.progress import track

from ncf_fenicsx.workers.cluster import Connection
from ncf_fenicsx.workers.rows import Point, Rows

Outcome = dict[str, str]
Work = Callable[[Point], Outcome]
"""What a worker does with a point. It goes to another process, so it is a function or an object of a module."""
ENDING, REASON = "ending", "reason"
LOOK = 1.0
"""Seconds after which the scheduler is looked at where nothing has ended."""


def run_missing(
    points: Iterable[Point],
    inputs: Sequence[str],
    outcomes: Sequence[str],
    work: Work,
    connection: Connection,
    rows: Path,
) -> None:
    """Run the points that have no row yet.

    Args:
        points: values of the inputs.
        inputs: their headings.
        outcomes: headings of what work comes to; where it does not tell one the cell is empty.
        work: what a worker does with each point.
        connection: to the scheduler of the workers.
        rows: CSV file that gets a row when a run has ended.

    Raises:
        SceneError: the file has rows of other inputs, or another study writes it.
        ResultError: rows cannot be written, or the scheduler has gone.
    """
    with Rows(rows, inputs, outcomes) as file:
        missing = [point for point in dict.fromkeys(points) if point not in file.known]
        for point, outcome in track(results(connection, work, missing), "runs", total=len(missing)):
            file.append(dict.fromkeys(outcomes, "") | dict(zip(inputs, point, strict=True)) | outcome)


def results(connection: Connection, work: Work, points: Iterable[Point]) -> Iterator[tuple[Point, Outcome]]:
    """What each point comes to, in the order in which runs end.

    As many runs are on their way as workers can do at a time. A run whose worker dies is tried again by
    the scheduler; those that were on their way when a scheduler went are handed to the next one.

    Args:
        connection: to the scheduler.
        work: done by a worker for each point.
        points: taken one at a time.

    Raises:
        ResultError: the scheduler has gone for good.
    """
    again: deque[Point] = deque()
    source = iter(points)
    pending: dict[Any, Point] = {}
    while True:
        if connection.broken:
            again.extend(pending.values())
            pending.clear()
            connection.renew()
        _fill(connection, work, pending, again, source)
        if not pending and not again:
            return
        for future in _ended(pending):
            point = pending.pop(future)
            outcome = _outcome(future)
            if outcome is None:
                again.append(point)
            else:
                yield point, outcome


def _fill(
    connection: Connection, work: Work, pending: dict[Any, Point], again: deque[Point], source: Iterator[Point]
) -> None:
    """Hand over as many points as workers can do at a time, those that got lost first."""
    room = connection.at_a_time
    while len(pending) < room:
        if not again:
            again.extend(islice(source, 1))
        if not again:
            return
        point = again.popleft()
        pending[connection.client.submit(work, point, pure=False)] = point


def _ended(pending: dict[Any, Point]) -> list[Any]:
    """Runs that have ended or got lost; waits a while for the first."""
    with suppress(TimeoutError, CancelledError):
        wait(list(pending), timeout=LOOK, return_when="FIRST_COMPLETED")
    return [future for future in pending if future.status != "pending"]


def _outcome(future: Any) -> Outcome | None:
    """What a run has come to; None where it got lost with its scheduler."""
    if future.status == "error":
        error = future.exception()
        if isinstance(error, KilledWorker):
            return {ENDING: "error", REASON: "its worker has died at each try"}
        return {ENDING: "error", REASON: f"{type(error).__name__}: {error}"}
    try:
        return dict(future.result()) if future.status == "finished" else None
    except (OSError, CancelledError):
        return None
