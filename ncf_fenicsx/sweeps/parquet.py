"""Rows as a Parquet file: numbers are numbers there, and the unit of each column is in its metadata."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.parameters.units import parse_number
from ncf_fenicsx.workers.rows import read_rows

UNIT = re.compile(r"(?P<name>.*?)(?: \[(?P<unit>[^\]]*)\])?")
AT_A_TIME = 1000
"""Rows that are in memory at a time."""


def write_parquet(rows: Path) -> Path:
    """Write a file of rows beside itself as ``.parquet``.

    Columns whose cells are all numbers, or empty, are numbers of 8 bytes, the others text. ``b"unit"`` in the metadata
    of a column is its SI unit; its name is that of the heading without it.

    Raises:
        ResultError: it cannot be written.
    """
    path = rows.with_suffix(".parquet")
    schema = _schema(rows)
    replace(path, lambda beside: _write(rows, beside, schema))
    return path


def _write(rows: Path, path: Path, schema: Any) -> None:
    source = read_rows(rows)
    with parquet.ParquetWriter(path, schema) as writer:
        while some := [list(row.values()) for row in islice(source, AT_A_TIME)]:
            columns = [_cells(field.type, cells) for field, cells in zip(schema, zip(*some, strict=True), strict=True)]
            writer.write_batch(pa.record_batch(columns, schema=schema))


def _cells(kind: Any, texts: Sequence[str]) -> Any:
    return pa.array([float(text) if text else None for text in texts] if kind == pa.float64() else texts, kind)


def _schema(rows: Path) -> Any:
    """Names, types and units of the columns."""
    words: dict[str, bool] = {}
    for row in read_rows(rows):
        for heading, text in row.items():
            words[heading] = words.get(heading, False) or bool(text and parse_number(text) is None)
    fields = []
    for heading, wordy in words.items():
        match = UNIT.fullmatch(heading)
        name, unit = (match["name"], match["unit"]) if match else (heading, None)
        fields.append(pa.field(name, pa.string() if wordy else pa.float64(), metadata={"unit": unit} if unit else None))
    return pa.schema(fields)
