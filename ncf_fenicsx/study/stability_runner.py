"""Cases of a scene, each run by a worker; a table with a row for each that can be resumed."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx.report.reading import read_record
from ncf_fenicsx.study.stability_grid import Case
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.engine import Outcome, run_missing
from ncf_fenicsx.workers.launch import BARE, Ended, launch
from ncf_fenicsx.workers.rows import Point, Row, read_rows

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


INPUTS = COLUMNS[:3]


@dataclass(frozen=True)
class CaseWork:
    """What a worker does with a case: runs it, and again with smaller steps.

    Attributes:
        scene: its file.
        folder: for the runs.
        overrides: of the scene, for all cases.
        refinement: factor on the steps of the run that each case is compared with.
        limit: wall time in s after which a run is ended.
        cases: by their points.
    """

    scene: Path
    folder: Path
    overrides: tuple[str, ...]
    refinement: float
    limit: float
    cases: dict[Point, Case]

    def __call__(self, point: Point) -> Outcome:
        """Outcome of the case of a point, and its force against the same with smaller steps."""
        return self._measured(self.cases[point])

    def _measured(self, case: Case) -> Outcome:
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
        record = read_record(self.folder / case.name)
        return float(record["time"] / record["steps"])

    def _one(self, case: Case, suffix: str, more: tuple[str, ...] = ()) -> Outcome:
        out = self.folder / (case.name + suffix)
        ended = launch(self.scene, out, (*self.overrides, *case.overrides, *more, *BARE), self.limit)
        if ended.ending in ("time limit", "error"):
            return {"ending": ended.ending, "reason": ended.reason}
        return _result(ended)


@dataclass(frozen=True)
class Runner:
    """Runs cases of a scene.

    Attributes:
        scene: its file.
        folder: for the table and the runs.
        overrides: of the scene, for all cases.
        refinement: factor on the steps of the run that each case is compared with.
        limit: wall time in s after which a run is ended.
        place: where runs are done.
    """

    scene: Path
    folder: Path
    overrides: tuple[str, ...]
    refinement: float
    limit: float
    place: Place

    @property
    def table(self) -> Path:
        """File with a row for each case."""
        return self.folder / "stability.csv"

    def run(self, cases: Iterable[Case]) -> list[Row]:
        """Run the cases that the table does not have yet; all its rows.

        Raises:
            SceneError: the scheduler does not answer, or the table has other columns.
            ResultError: rows cannot be written, or the scheduler has gone.
        """
        points: dict[Point, Case] = {(case.axis, case.value, str(case.sound).lower()): case for case in cases}
        runs = self.folder.resolve() / "runs"
        work = CaseWork(self.scene.resolve(), runs, self.overrides, self.refinement, self.limit, points)
        with self.place.opened() as connection:
            run_missing(points, INPUTS, COLUMNS[len(INPUTS) :], work, connection, self.table)
        return list(read_rows(self.table))


def _result(ended: Ended) -> Outcome:
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
