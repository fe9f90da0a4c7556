"""Error against run time: variants of a scene, each with its error against a reference and what it cost."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.results_folder import ACCURACY
from ncf_fenicsx.report.closing import drawn_or_told
from ncf_fenicsx.report.page import PAGE
from ncf_fenicsx.report.reading import read_history, read_record
from ncf_fenicsx.report.reference_solution import Extrapolated, VfField
from ncf_fenicsx.report.study_page import write_study
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.study.choice import chosen
from ncf_fenicsx.study.error_grid import TOGETHER, Variant, Variants
from ncf_fenicsx.study.machine import machine
from ncf_fenicsx.study.work_precision import draw_work_precision
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.engine import Outcome, run_missing
from ncf_fenicsx.workers.launch import BARE, launch, launch_levels
from ncf_fenicsx.workers.rows import Point, Row, read_rows, write_rows

MEASURED = ("force_N", "vf_max", "void_m3")
"""Largest of a run: force on the first tool, Vf, and volume of all voids."""
COST = ("seconds", "seconds_cpu", "memory_mb", "iterations", "steps", "unknowns", "ranks")
COLUMNS = ("method", "level", "ending", "reason", *MEASURED, "vf_estimate", *COST)
ERRORS = ("force_error", "vf_max_error", "void_error", "vf_field_error", "effectivity")
INPUTS = COLUMNS[:2]
REFERENCE = ("quantity", "limit", "observed_order", "off_the_finest")
TARGETS = (0.05, 0.02, 0.01)


@dataclass(frozen=True)
class VariantWork:
    """What a worker does with a variant of a scene.

    Attributes:
        file: the scene's file.
        folder: for the runs.
        overrides: of the scene, for all variants.
        limit: wall time in s after which a run is ended.
        through: whether meshes are refined through the layers too.
        variants: by their points.
    """

    file: Path
    folder: Path
    overrides: tuple[str, ...]
    limit: float
    through: bool
    variants: dict[Point, Variant]

    def __call__(self, point: Point) -> Outcome:
        """Outcome of the variant of a point."""
        variant = self.variants[point]
        return (self._sequence if variant.by_levels else self._single)(variant, self.folder / variant.name)

    def _single(self, variant: Variant, folder: Path) -> Outcome:
        overrides = (*self.overrides, *variant.overrides, *BARE)
        ended = launch(self.file, folder, overrides, self.limit, variant.command, variant.ranks)
        outcome = {"ending": ended.ending, "reason": ended.reason}
        return outcome | (self._figures([folder]) if ended.ending == "done" else {})

    def _sequence(self, variant: Variant, folder: Path) -> Outcome:
        """One that has taken too long has an answer too, but not the one asked for."""
        overrides = (*self.overrides, *variant.overrides, *BARE)
        ended, answer = launch_levels(self.file, folder, overrides, self.limit)
        if not answer:
            return {"ending": ended.ending, "reason": ended.reason}
        if not answer["met"]:
            return {"ending": "stopped", "reason": answer["ending"]}
        return {"ending": "done", "reason": answer["ending"]} | self._figures(runs_of(folder))

    def _figures(self, folders: list[Path]) -> Outcome:
        """What runs that are done have cost together, and what the last one tells.

        The estimate is of what the reference refines.
        """
        estimate = "vf_error" if self.through else "vf_error_in_plane"
        history, records = read_history(folders[-1] / "history.csv"), [read_record(folder) for folder in folders]
        voids = [history[name] for name in history.dtype.names if name.startswith("void_volume")]
        iterations = [one.get("newton_iterations", one.get("explicit", {}).get("steps")) for one in records]
        cost = {
            "seconds": f"{sum(one['seconds_total'] - one['seconds']['forms'] for one in records):.3f}",
            "seconds_cpu": f"{sum(one['seconds_cpu'] for one in records):.3f}",
            "memory_mb": f"{max(one['peak_memory_mb'] for one in records):.0f}",
            "iterations": str(sum(iterations)),
            "steps": str(sum(one["steps"] for one in records)),
            "unknowns": str(records[-1]["unknowns"]),
            "ranks": str(records[-1]["ranks"]),
        }
        return cost | {
            "force_N": f"{history['tool_force'].max():.8g}",
            "vf_max": f"{history['vf_max'].max():.8g}",
            "void_m3": f"{np.sum(voids, axis=0).max() if voids else 0.0:.8g}",
            "vf_estimate": f"{history[estimate][-1]:.3g}",
        }


def runs_of(folder: Path) -> list[Path]:
    """Folders of the runs of a variant: its own, or those of the levels of a sequence, the finest one last."""
    if not (folder / ACCURACY).is_file():
        return [folder]
    levels = json.loads((folder / ACCURACY).read_text("utf-8"))["levels"]
    return [folder / f"level_{level['level']}" for level in levels]


@dataclass(frozen=True)
class ErrorTime:
    """A study of one scene.

    Attributes:
        file: the scene's file.
        folder: for tables, picture and runs.
        overrides: of the scene, for all variants.
        limit: wall time in s after which a run is ended.
        along_y: whether meshes are refined along y too.
        levels: refinements that the reference is made of, three or more.
        through: whether meshes are refined through the layers too.
    """

    file: Path
    folder: Path
    overrides: tuple[str, ...]
    limit: float
    along_y: bool
    levels: int
    through: bool

    def run(self, methods: list[str] | None = None) -> str:
        """Run what is missing, one run after the other, and weigh all; what it comes to in words.

        Args:
            methods: beginnings of the names of the methods to run; all unless given. The reference always is.

        Raises:
            SceneError: the scene cannot be varied, a method is unknown, or the reference does not end.
        """
        scene = Scene.read(self.file, self.overrides)
        variants = Variants(scene, self.along_y, self.levels, self.through).all()
        wanted = {TOGETHER} | chosen((variant.method for variant in variants), methods, "method")
        weighed = [variant for variant in variants if variant.method in wanted]
        points: dict[Point, Variant] = {(one.method, one.level): one for one in weighed}
        work = VariantWork(self.file.resolve(), self._runs.resolve(), self.overrides, self.limit, self.through, points)
        with Place(workers=1).opened() as connection:
            run_missing(points, INPUTS, COLUMNS[len(INPUTS) :], work, connection, self._table)
        rows = self._weighed(weighed, scene)
        write_rows(self.folder / "error_time.csv", (*COLUMNS, *ERRORS), rows)
        title = f"{scene.title}: error against run time, {machine()}"
        draw_work_precision(rows, title, self.folder / "error_time.png")
        told = drawn_or_told(self.folder, {PAGE: write_study})
        words = [advice(rows), *(f"caution: {one}" for one in told), f"tables, picture and page in {self.folder}"]
        return "\n".join(words)

    @property
    def _table(self) -> Path:
        return self.folder / "runs.csv"

    @property
    def _runs(self) -> Path:
        return self.folder / "runs"

    def _folder_of(self, variant: Variant) -> Path:
        return runs_of(self._runs / variant.name)[-1]

    def _weighed(self, variants: list[Variant], scene: Scene) -> list[Row]:
        """Rows of the variants with their errors."""
        rows = {(row["method"], row["level"]): row for row in read_rows(self._table)}
        levels = [variant for variant in variants if variant.method == TOGETHER]
        refined = [rows[variant.method, variant.level] for variant in levels]
        if any(row["ending"] != "done" for row in refined):
            words = next(row["reason"] for row in refined if row["ending"] != "done")
            raise SceneError(f"study error-time: the reference is not done: {words}; expected a scene that is")
        limits = {name: Extrapolated.of(*(float(row[name]) for row in refined[-3:])) for name in MEASURED}
        self._write_limits(limits)
        field, rest = VfField(self._folder_of(levels[-1])), scene.stack.initial_volume_fraction
        weighed = []
        for variant in variants:
            row = dict.fromkeys((*COLUMNS, *ERRORS), "") | rows[variant.method, variant.level]
            if row["ending"] == "done":
                row |= _errors(row, limits, variant is levels[-1])
            if row["ending"] == "done" and variant is not levels[-1]:
                off = VfField(self._folder_of(variant)).off(field, rest)
                row["vf_field_error"] = f"{off:.3g}"
                row["effectivity"] = f"{float(row['vf_estimate']) / off:.3g}"
            weighed.append(row)
        return weighed

    def _write_limits(self, limits: dict[str, Extrapolated]) -> None:
        rows = [(name, str(one.value), str(one.order), str(one.uncertainty)) for name, one in limits.items()]
        named = [dict(zip(REFERENCE, row, strict=True)) for row in rows]
        write_rows(self.folder / "reference.csv", REFERENCE, named)


def _errors(row: Row, limits: dict[str, Extrapolated], finest: bool) -> Row:
    """Relative differences from the limits; the finest has none where it is the limit itself."""
    errors = {}
    for name, error in zip(MEASURED, ERRORS, strict=False):
        limit = limits[name]
        known = limit.value and not (finest and math.isnan(limit.order))
        errors[error] = f"{abs(float(row[name]) / limit.value - 1):.3g}" if known else ""
    return errors


def advice(rows: list[Row]) -> str:
    """For each target, the cheapest variant whose force is no further off."""
    done = [row for row in rows if row["force_error"]]
    words = []
    for target in TARGETS:
        enough = [row for row in done if float(row["force_error"]) <= target]
        if enough:
            best = min(enough, key=lambda row: float(row["seconds"]))
            cost = f"{float(best['seconds']):.1f} s, {best['memory_mb']} MB"
            off = f"off by {100 * float(best['force_error']):.2g} %"
            words.append(f"for {100 * target:g} % in force use {best['method']} {best['level']}: {cost}, {off}")
        else:
            words.append(f"for {100 * target:g} % in force none of these is enough")
    return "\n".join(words)
