"""The runs of a plan, or what is missing of them: a row for each on the disk, from which everything else is made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import replace, told
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.sweeps.inputs import Column, Reader
from ncf_fenicsx.sweeps.outcomes import MEASURES
from ncf_fenicsx.sweeps.plans import Plan
from ncf_fenicsx.sweeps.scene_work import SceneWork
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.engine import ENDING, REASON, Work, run_missing

ROWS, SCENE, RUN = "rows.csv", "scene.toml", "run"


@dataclass(frozen=True)
class Campaign:
    """Many runs of a scene.

    Attributes:
        file: of the scene.
        overrides: ``key=value`` texts for all runs.
        folder: for the rows and the runs; one that has some is gone on with.
        place: where runs are done.
        limit: wall time in s after which a run is ended.
    """

    file: Path
    overrides: tuple[str, ...]
    folder: Path
    place: Place
    limit: float

    @property
    def reader(self) -> Reader:
        """Reads values as the scene does."""
        return Reader(self.file, self.overrides)

    @property
    def rows(self) -> Path:
        """File of the rows."""
        return self.folder / ROWS

    def run(self, plan: Plan) -> None:
        """Run what is missing of a plan.

        Raises:
            SceneError: the folder has runs of another scene, or the scheduler does not answer.
            ResultError: rows cannot be written, or the scheduler has gone.
        """
        outcomes = [RUN, *(measure.heading for measure in MEASURES), ENDING, REASON]
        self.hand_over(plan, self.work(plan.columns), self.rows, outcomes)

    def work(self, columns: tuple[Column, ...]) -> SceneWork:
        """What a worker does with a point of these columns."""
        runs = self.folder.resolve() / "runs"
        return SceneWork(self.file.resolve(), runs, self.overrides, columns, self.limit, self.place.ranks)

    def hand_over(self, plan: Plan, work: Work, rows: Path, outcomes: Sequence[str]) -> None:
        """Do some work with what is missing of a plan; a row for each point in a file of its own.

        Raises:
            SceneError: the folder has runs of another scene, or the scheduler does not answer.
            ResultError: rows cannot be written, or the scheduler has gone.
        """
        text, kept = Scene.read(self.file, self.overrides).to_toml(), self.folder / SCENE
        if kept.exists() and kept.read_text("utf-8") != text:
            raise SceneError(f"{self.folder}: has runs of another scene; name another folder with --out")
        with self.place.opened() as connection:
            with told(self.folder):
                self.folder.mkdir(parents=True, exist_ok=True)
            replace(kept, lambda path: path.write_text(text, encoding="utf-8"))
            run_missing(plan.points(), plan.headings, outcomes, work, connection, rows)
