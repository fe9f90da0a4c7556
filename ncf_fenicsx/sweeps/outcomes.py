"""What a sweep keeps of a run: a few numbers of its history, with units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.workers.engine import ENDING, REASON, Outcome
from ncf_fenicsx.workers.launch import Ended

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """A number of a run.

    Attributes:
        name: of its column.
        unit: SI unit.
        words: what it is.
    """

    name: str
    unit: str
    words: str

    @property
    def heading(self) -> str:
        """Of its column, as ``force [N]``."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


FORCE = Measure("force", "N", "largest force on the tool")
VF = Measure("vf_max", "", "largest Vf")
VOID = Measure("void_volume", "m3", "largest volume of the voids")
WRINKLE = Measure("wrinkle_height", "m", "highest wrinkle")
ERROR = Measure("vf_error", "", "estimated error of the field of Vf by the mesh")
SECONDS = Measure("seconds", "s", "run time")
RESULTS = (FORCE, VF, VOID, WRINKLE)
"""What effects, indices and distributions are of."""
MEASURES = (*RESULTS, ERROR, SECONDS)


def measured(ended: Ended) -> Outcome:
    """Outcome of a run of a scene; numbers only of one that is done, others have not come as far."""
    outcome = {measure.heading: "" for measure in MEASURES} | {ENDING: ended.ending, REASON: ended.reason}
    if ended.ending != "done":
        return outcome
    history = read_history(ended.folder / "history.csv")
    for measure, value in (
        (FORCE, lambda: history["tool_force"].max()),
        (VF, lambda: history["vf_max"].max()),
        (VOID, lambda: np.sum(_columns(history, "void_volume"), axis=0).max()),
        (WRINKLE, lambda: max(column.max() for column in _columns(history, "wrinkle_height"))),
        (ERROR, lambda: history["vf_error"][-1]),
        (SECONDS, lambda: ended.record["seconds_total"]),
    ):
        outcome[measure.heading] = _text(value)
    return outcome


def _columns(history: Any, name: str) -> list[Floats]:
    """Columns of that name, of all faces; one of zeros where there is none."""
    found = [history[column] for column in history.dtype.names if column.removeprefix("mould_").startswith(name)]
    return found or [np.zeros(len(history))]


def _text(value: Callable[[], Any]) -> str:
    """Eight digits of a number; empty where the history has no such column, as a solid has no Vf."""
    try:
        return f"{float(value()):.8g}"
    except ValueError:
        return ""
