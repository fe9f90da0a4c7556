"""Rows of runs on the disk: one line a run, whole or not there, written by one process and never held in memory."""

from __future__ import annotations

import csv
import fcntl
import io
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import replace, told

Point = tuple[str, ...]
"""Values of all inputs as text, quantities in SI: what a row begins with, and what tells runs apart."""
Row = dict[str, str]


class Rows:
    """A CSV file of rows, to be entered before it is written: nobody else can write it then.

    A line that was half written when its writer was killed is cut off: its run has no row.

    Args:
        path: of the file; it and its folder are made at the first row.
        inputs: headings that tell runs apart.
        outcomes: headings of what runs come to.
    """

    def __init__(self, path: Path, inputs: Sequence[str], outcomes: Sequence[str]) -> None:
        self.path, self._headings, self._inputs = path, [*inputs, *outcomes], len(inputs)
        self.known: set[Point] = set()
        self._file: io.FileIO | None = None

    def __enter__(self) -> Self:
        """Lock the file, and read which runs it has.

        Raises:
            SceneError: another process writes it, or it has rows of other inputs.
            ResultError: it cannot be written.
        """
        with told(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = io.FileIO(self.path, "a+")
        try:
            self._begin(self._file)
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        del kind, error, trace
        if self._file is not None:
            self._file.close()

    def append(self, row: Row) -> None:
        """Add a row; it is on the disk afterwards.

        Raises:
            ResultError: it cannot be written; the rows before stay.
        """
        self._write([" ".join(row[name].split()) for name in self._headings])
        self.known.add(tuple(row[name] for name in self._headings[: self._inputs]))

    def _begin(self, file: io.FileIO) -> None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise SceneError(f"{self.path}: another study writes there; name another folder with --out") from error
        with told(self.path):
            file.truncate(_end_of_whole_lines(file))
        if self.path.stat().st_size == 0:
            self._write(self._headings)
        with self.path.open(newline="", encoding="utf-8") as lines:
            reader = csv.reader(lines)
            found = next(reader)
            if found != self._headings:
                raise SceneError(f"{self.path}: has rows of other inputs: {', '.join(found)}; name another --out")
            self.known = {tuple(cells[: self._inputs]) for cells in reader}

    def _write(self, cells: Sequence[str]) -> None:
        line = io.StringIO()
        csv.writer(line).writerow(cells)
        with told(self.path):
            assert self._file is not None
            before = self._file.seek(0, os.SEEK_END)
            try:
                self._file.write(line.getvalue().encode())
                os.fsync(self._file.fileno())
            except OSError:
                self._file.truncate(before)
                raise


def read_rows(path: Path) -> Iterator[Row]:
    """Rows of a file, one at a time."""
    with path.open(newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def write_rows(path: Path, headings: Sequence[str], rows: Sequence[Row]) -> None:
    """Have these rows in a file, in place of any there are.

    Raises:
        ResultError: they cannot be written; the old ones stay.
    """
    replace(path, lambda beside: _write_all(beside, headings, rows))


def _write_all(path: Path, headings: Sequence[str], rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, headings)
        writer.writeheader()
        writer.writerows(rows)


def _end_of_whole_lines(file: io.FileIO) -> int:
    """Bytes up to the end of the last whole line."""
    end = file.seek(0, os.SEEK_END)
    while end:
        start = max(end - 4096, 0)
        file.seek(start)
        place = file.read(end - start).rfind(b"\n")
        if place >= 0:
            return start + place + 1
        end = start
    return 0
