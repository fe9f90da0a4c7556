"""CSV tables of nodes and of cells: what any program, or a spreadsheet, reads."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from ncf_fenicsx.export.deformed import Deformed
from ncf_fenicsx.export.files import Writer


def csv_files(deformed: Deformed) -> dict[str, Writer]:
    """``nodes.csv`` and ``cells.csv``, in SI, a row for each; cells name their nodes by number, from 1."""
    nodes: dict[str, Any] = {"node": range(1, len(deformed.points) + 1)}
    nodes |= dict(zip("xyz", deformed.points.T, strict=True))
    nodes |= dict(zip(("reference_x", "reference_y", "reference_z"), deformed.layers.points.T, strict=True))
    nodes |= deformed.node_fields
    cells: dict[str, Any] = {"cell": range(1, len(deformed.cells) + 1), "layer": deformed.layers.layer}
    cells |= {f"node_{number + 1}": 1 + deformed.cells[:, number] for number in range(8)}
    middle = deformed.points[deformed.cells].mean(axis=1)
    cells |= dict(zip("xyz", middle.T, strict=True))
    cells |= deformed.cell_fields
    return {"nodes.csv": table_writer(nodes), "cells.csv": table_writer(cells)}


def table_writer(columns: dict[str, Any]) -> Writer:
    """What writes columns by name as CSV; numbers are written so that they read back the same."""

    def write(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            plain = [getattr(values, "tolist", lambda values=values: list(values))() for values in columns.values()]
            writer.writerows(zip(*plain, strict=True))

    return write
