"""Runs of cases in processes of their own, several at a time; a table with a row for each that can be resumed."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from rich.progress import track

from ncf_fenicsx.report.reading import read_record
from ncf_fenicsx.study.launch import BARE, Ended, launch
from ncf_fenicsx.study.stability_grid import Case
from ncf_fenicsx.study.table import Row, Table

COLUMNS = (
    "axis",
    "value",
    "sound",
    "ending",
    "reason",
    "reached_s",
    "force_N",
    "vf_max",
    "iterations",
    "cuts",
    "steps",
    "seconds",
    "stability_lost_s",
    "viscous_share",
    "reference_force_N",
    "difference",
)


@dataclass(frozen=True)
class Runner:
    """Runs cases of a scene.

    Attributes:
        scene: its file.
        folder: for the table and the runs.
        overrides: of the scene, for all cases.
        refinement: factor on the steps of the run that each case is compared with.
        limit: wall time in s after which a run is ended.
        workers: runs at a time.
    """

    scene: Path
    folder: Path
    overrides: tuple[str, ...]
    refinement: float
    limit: float
    workers: int

    @property
    def table(self) -> Table:
        """A row for each case."""
        return Table(self.folder / "stability.csv", COLUMNS, ("axis", "value"))

    def run(self, cases: Iterable[Case]) -> list[Row]:
        """Run the cases that the table does not have yet; all its rows."""
        self.folder.mkdir(parents=True, exist_ok=True)
        known = self.table.known()
        missing = [case for case in cases if (case.axis, case.value) not in known]
        with ThreadPoolExecutor(self.workers) as pool:
            started = [pool.submit(self.measured, case) for case in missing]
            for done in track(as_completed(started), "runs", total=len(started)):
                self.table.append(done.result())
        return self.table.rows()

    def measured(self, case: Case) -> Row:
        """A case, and its force against the same with smaller steps."""
        row = self._one(case, "")
        if row["ending"] != "done":
            return row
        size = self._mean_step(case) / self.refinement
        steps = (
            f"solver.first_step={size!r} s",
            f"solver.largest_step={size!r} s",
            "solver.max_steps=100000",
            "solver.time_tolerance=1",
        )
        reference = self._one(case, "_reference", steps)
        if reference["ending"] == "done" and float(reference["force_N"]):
            row["reference_force_N"] = reference["force_N"]
            row["difference"] = f"{float(row['force_N']) / float(reference['force_N']) - 1:.6f}"
        return row

    def _mean_step(self, case: Case) -> float:
        """Mean step in s of a case's run that has ended."""
        record = read_record(self.folder / "runs" / case.name)
        return float(record["time"] / record["steps"])

    def _one(self, case: Case, suffix: str, more: tuple[str, ...] = ()) -> Row:
        out = self.folder / "runs" / (case.name + suffix)
        ended = launch(self.scene, out, (*self.overrides, *case.overrides, *more, *BARE), self.limit)
        if ended.ending in ("time limit", "error"):
            return _row(case, ending=ended.ending, reason=ended.reason)
        return _row(case, **_result(ended))


def _row(case: Case, **values: str) -> Row:
    row = dict.fromkeys(COLUMNS, "")
    return row | {"axis": case.axis, "value": case.value, "sound": str(case.sound).lower()} | values


def _result(ended: Ended) -> Row:
    """What a run's folder says."""
    record, file = ended.record, ended.folder / "history.csv"  # which there is none of where a stack does not settle
    rows = list(csv.DictReader(file.read_text("utf-8").splitlines())) if file.exists() else []
    largest = max((float(row["tool_force"]) for row in rows), default=0.0)
    lost = record["loss_of_stability"]
    return {
        "ending": ended.ending,
        "reason": ended.reason,
        "reached_s": f"{record['time']:.6g}",
        "force_N": f"{largest:.6g}",
        "vf_max": f"{max((float(row['vf_max']) for row in rows), default=0.0):.5f}",
        "iterations": str(record["newton_iterations"]),
        "cuts": str(record["step_cuts"]),
        "steps": str(record["steps"]),
        "seconds": f"{record['seconds_total']:.1f}",
        "stability_lost_s": f"{lost['time']:.6g}" if lost else "",
        "viscous_share": f"{float(rows[-1].get('viscous_share', 0)):.2g}" if rows else "",
    }
