"""What a worker does with a point: the scene with its values, run in processes of its own."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.sweeps.inputs import Column
from ncf_fenicsx.sweeps.outcomes import measured
from ncf_fenicsx.workers.engine import Outcome
from ncf_fenicsx.workers.launch import BARE, launch
from ncf_fenicsx.workers.rows import Point

OUTCOME = "outcome.json"
"""Written when a run has ended: a run whose row got lost on its way is not run again."""


@dataclass(frozen=True)
class SceneWork:
    """Runs a scene at points; the scene and the folder are seen by all workers under these paths.

    Attributes:
        file: of the scene.
        folder: for a folder of each run.
        overrides: ``key=value`` texts for all runs.
        columns: keys that points have values of.
        limit: wall time in s after which a run is ended.
        ranks: processes of each run.
    """

    file: Path
    folder: Path
    overrides: tuple[str, ...]
    columns: tuple[Column, ...]
    limit: float
    ranks: int = 1

    def __call__(self, point: Point) -> Outcome:
        """Run it; what it comes to."""
        folder = self.folder / name_of(point)
        if (folder / OUTCOME).is_file():
            return dict(json.loads((folder / OUTCOME).read_text("utf-8")))
        varied = [column.override(value) for column, value in zip(self.columns, point, strict=True)]
        ended = launch(self.file, folder, (*self.overrides, *varied, *BARE), self.limit, ranks=self.ranks)
        outcome = {"run": folder.name} | measured(ended)
        folder.mkdir(parents=True, exist_ok=True)
        replace(folder / OUTCOME, lambda path: path.write_text(json.dumps(outcome), encoding="utf-8"))
        return outcome


def name_of(point: Point) -> str:
    """Name of the folder of a point's run, the same in a plan that has grown."""
    return hashlib.sha256("\n".join(point).encode()).hexdigest()[:12]
