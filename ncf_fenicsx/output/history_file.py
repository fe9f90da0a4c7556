"""The history of a run as a CSV file: a row is on the disk when it is appended, and no row is ever half there."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from ncf_fenicsx.output.safe_files import replace, told

Row = dict[str, float]


class HistoryFile:
    """A ``history.csv``.

    Args:
        path: of the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._header: list[str] = []

    def append(self, row: Row) -> None:
        """Add a row; the first one makes the file and its header.

        Raises:
            ResultError: it cannot be written; the rows before stay.
        """
        new = not self._header
        self._header = self._header or list(row)
        with told(self.path), self.path.open("w" if new else "a", newline="", encoding="utf-8") as file:
            before = 0 if new else file.seek(0, os.SEEK_END)
            try:
                # a restart may bring a solver that measures more, or less
                writer = csv.DictWriter(file, self._header, restval="nan", extrasaction="ignore")
                if new:
                    writer.writeheader()
                writer.writerow(row)
                file.flush()
                os.fsync(file.fileno())
            except OSError:
                os.truncate(self.path, before)
                raise

    def cut(self, rows: int) -> list[Row]:
        """Keep a number of rows of a file that exists, and go on after them.

        Returns:
            Those rows.
        """
        with self.path.open(newline="", encoding="utf-8") as file:
            lines = [line for _, line in zip(range(rows + 1), file, strict=False)]
        replace(self.path, lambda path: path.write_text("".join(lines), encoding="utf-8", newline=""))
        reader = csv.DictReader(lines)
        kept = [{name: float(value) for name, value in row.items()} for row in reader]
        self._header = list(reader.fieldnames or ())
        return kept
