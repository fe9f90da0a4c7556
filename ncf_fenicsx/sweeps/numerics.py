"""How far the runs of a study are off by their mesh, steps and penalties: one of them, refined until bars are small.

The run in the middle of all inputs is done as the others are, and again by levels, each finer than the last
(`accuracy`). A result of the runs is then off by its distance from the finest level, and the error bar of that at most.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ncf_fenicsx.sweeps.campaign import Campaign
from ncf_fenicsx.sweeps.inputs import Column
from ncf_fenicsx.sweeps.outcomes import FORCE, RESULTS, VF, VOID, WRINKLE, Measure
from ncf_fenicsx.sweeps.plans import Plan
from ncf_fenicsx.sweeps.scene_work import SceneWork, name_of
from ncf_fenicsx.workers.engine import ENDING, REASON, Outcome
from ncf_fenicsx.workers.launch import BARE, launch_levels
from ncf_fenicsx.workers.rows import Point, read_rows

QUANTITIES = {FORCE: "force", VF: "vf", VOID: "void_volume", WRINKLE: "wrinkle_height"}
"""Results with their names in ``[accuracy]``."""
TOLERANCE = Column("accuracy.tolerance", "%")
ROWS = "numerics.csv"
KINDS = ("", "finest ", "bar of ")
"""What headings of the row have before those of the results."""


@dataclass(frozen=True)
class Refinement:
    """What the levels are asked for.

    Attributes:
        tolerance: largest bar over its size.
        quantities: of ``[accuracy]``.
    """

    tolerance: float
    quantities: tuple[str, ...]


@dataclass(frozen=True)
class Numerics:
    """A result of the run in the middle.

    Attributes:
        value: of the run as the others are.
        finest: of the finest level.
        bar: how far the limit of all levels is off that at most.
    """

    value: float
    finest: float
    bar: float

    @property
    def error(self) -> float:
        """How far the runs are off at most."""
        return abs(self.value - self.finest) + self.bar


@dataclass(frozen=True)
class NumericsWork:
    """Runs a scene as a study does, and by levels, at a point that ends with the tolerance of the levels.

    Attributes:
        plain: runs it as the study does.
        quantities: of ``[accuracy]``, whose bars are asked for; that of wrinkles only where the plain run has one.
    """

    plain: SceneWork
    quantities: tuple[str, ...]

    def __call__(self, point: Point) -> Outcome:
        """Values as in the study, values of the finest level, and their bars."""
        work = self.plain
        found = work(point[:-1])
        if found[ENDING] != "done":
            return {key: found[key] for key in (ENDING, REASON)}
        varied = [column.override(value) for column, value in zip((*work.columns, TOLERANCE), point, strict=True)]
        flat = float(found[WRINKLE.heading]) == 0
        asked = [name for name in self.quantities if not (flat and name == QUANTITIES[WRINKLE])]
        overrides = (*work.overrides, *varied, *BARE, f"accuracy.quantities={json.dumps(asked)}")
        folder = work.folder / f"{name_of(point)}_levels"
        ended, answer = launch_levels(work.file, folder, overrides, work.limit, work.ranks)
        if not answer:
            return {ENDING: ended.ending, REASON: ended.reason}
        return {ENDING: "done", REASON: answer["ending"]} | _cells(found, answer["quantities"])


def _cells(found: Outcome, levels: Mapping[str, Any]) -> Outcome:
    cells: Outcome = {}
    for measure, name in QUANTITIES.items():
        one = levels.get(name)
        if one is not None and one["bar"] is not None:
            cells[measure.heading] = found[measure.heading]
            cells[f"finest {measure.heading}"] = f"{one['value']:.8g}"
            cells[f"bar of {measure.heading}"] = f"{one['bar']:.8g}"
    return cells


def numerics_of(row: Mapping[str, str]) -> dict[Measure, Numerics]:
    """Results of a row that `NumericsWork` has come to."""
    found = {}
    for measure in RESULTS:
        cells = [row.get(f"{word}{measure.heading}", "") for word in KINDS]
        if all(cells):
            found[measure] = Numerics(*map(float, cells))
    return found


def numerics(
    campaign: Campaign, columns: tuple[Column, ...], middle: Point, asked: Refinement
) -> tuple[dict[Measure, Numerics], str]:
    """Results of the run in the middle, and how its levels ended.

    Raises:
        SceneError: the folder holds something else, or the scheduler does not answer.
        ResultError: the row cannot be written, or the scheduler has gone.
    """
    point = (*middle, TOLERANCE.text(100 * asked.tolerance))
    plan = Plan((*columns, TOLERANCE), 1, lambda: iter([point]))
    work = NumericsWork(campaign.work(columns), asked.quantities)
    headings = [f"{word}{measure.heading}" for measure in RESULTS for word in KINDS]
    campaign.hand_over(plan, work, campaign.folder / ROWS, [*headings, ENDING, REASON])
    names = [column.heading for column in plan.columns]
    row = next(row for row in read_rows(campaign.folder / ROWS) if tuple(row[name] for name in names) == point)
    return numerics_of(row), row[REASON]


def in_words(measure: Measure, one: Numerics, deviation: float) -> str:
    """The numerical error beside what the inputs make."""
    unit = f" {measure.unit}" if measure.unit else ""
    words = f"{measure.words}: off by {one.error:.2g}{unit} at most by mesh, steps and penalties"
    if not deviation > 0 or not math.isfinite(deviation):
        return words
    ratio = one.error / deviation
    return f"{words}, {ratio:.2g} times the standard deviation that the inputs make ({deviation:.2g}{unit})"
