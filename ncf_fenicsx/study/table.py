"""A table of runs as a CSV file that a study can go on with."""

from __future__ import annotations

import csv
from pathlib import Path

from ncf_fenicsx.output.safe_files import replace, told

Row = dict[str, str]


class Table:
    """Rows on the disk.

    Args:
        path: of the file.
        columns: its heading.
        key: columns that tell rows apart.
    """

    def __init__(self, path: Path, columns: tuple[str, ...], key: tuple[str, ...]) -> None:
        self.path, self.columns, self.key = path, columns, key

    def rows(self) -> list[Row]:
        """Rows so far."""
        if not self.path.exists():
            return []
        with self.path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def known(self) -> set[tuple[str, ...]]:
        """What tells the rows so far apart."""
        return {tuple(row[name] for name in self.key) for row in self.rows()}

    def write(self, rows: list[Row]) -> None:
        """Have these rows in place of any there are.

        Raises:
            ResultError: they cannot be written; the old ones stay.
        """
        replace(self.path, lambda path: self._write(path, rows))

    def _write(self, path: Path, rows: list[Row]) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(rows)

    def append(self, row: Row) -> None:
        """Add a row.

        Raises:
            ResultError: it cannot be written.
        """
        new = not self.path.exists()
        with told(self.path), self.path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns)
            if new:
                writer.writeheader()
            writer.writerow(row)
