"""Tables of numbers with their confidence, as CSV files."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.sweeps.estimates import Estimate, Estimates
from ncf_fenicsx.sweeps.outcomes import Measure

COLUMNS = ("result", "input", "quantity", "value", "low", "high")


def write_estimates(path: Path, found: Iterable[tuple[Measure, str, Estimates]]) -> None:
    """Write a row for each number.

    Args:
        path: of the file.
        found: result, name of the input if there is one, and numbers by name.

    Raises:
        ResultError: it cannot be written.
    """
    rows = [
        (measure.heading, one, name, *_cells(estimate))
        for measure, one, estimates in found
        for name, estimate in estimates.items()
    ]

    def write(beside: Path) -> None:
        with beside.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows(rows)

    replace(path, write)


def _cells(estimate: Estimate) -> list[str]:
    numbers = (estimate.value, estimate.low, estimate.high)
    return ["" if number is None else f"{number:.6g}" for number in numbers]
