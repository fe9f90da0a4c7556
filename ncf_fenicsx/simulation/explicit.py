"""An explicit companion: the same scene marched by central differences, to compare with."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

from mpi4py import MPI

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.time_step import TimeStep
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.claim import Claim
from ncf_fenicsx.output.measures import Measures
from ncf_fenicsx.output.results_folder import Results, prepare_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.scene_file import WRITTEN
from ncf_fenicsx.scene.settings import Explicit
from ncf_fenicsx.simulation.central_differences import CentralDifferences
from ncf_fenicsx.simulation.closing_pictures import draw_closing_pictures
from ncf_fenicsx.simulation.interruption import Interruption
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.simulation.run_record import Result, record, untouched, wrinkle
from ncf_fenicsx.simulation.start import build_problem
from ncf_fenicsx.simulation.stepping import Ending, March
from ncf_fenicsx.solver.timing import Phases

COLUMNS = {
    "kinetic_energy": ("J", "kinetic energy of the fabric with its scaled mass, of the whole"),
    "kinetic_share": (
        "1",
        "that over the internal energy: work of the tools less kinetic and damped; 1 if that is none",
    ),
    "damped_share": ("1", "energy that the damping of all motion has taken, over the work of the tools"),
    "explicit_steps": ("1", "steps of central differences in the row"),
}
"""Columns of ``history.csv`` that an explicit run has beside those of its scene."""
EARLY = 0.05
"""Share of the largest internal energy before which its ratio to the kinetic one says nothing: both begin at none."""
WEIGHING = 0.05
"""Share of the run in which the stack takes on its weight, so that it does not bounce on it."""


def run_explicit(
    scene: Scene,
    folder: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    overwrite: bool = False,
    written: str | None = None,
) -> Result:
    """March a scene by central differences on all ranks of ``comm`` and write its results.

    The stack takes on its weight while the run begins, and a run is called done only if it was quasi-static.

    Args:
        scene: the case.
        folder: for results; made if it does not exist.
        comm: ranks that share the work.
        overwrite: whether results in the folder may be replaced.
        written: text that the scene was read from, to be kept with the results.

    Raises:
        SceneError: the scene cannot be marched, or the folder cannot be used; nothing has been written then.
        ResultError: results could not be written; what was written before stays.
    """
    if any(tool.under_force for tool in scene.tool):
        raise SceneError("explicit: tool.path.N.force: expected tools whose height is given: they have no mass")
    if not scene.tool:
        raise SceneError("explicit: tool: expected one, whose work the kinetic energy is weighed against")
    solver = scene.solver.model_copy(update={"stabilisation": "none", "tangent": "plain", "perturbation": None})
    settings = scene.explicit or Explicit()
    bare = scene.model_copy(update={"solver": solver, "explicit": settings})
    with Claim(Path(folder), comm, overwrite):
        run = ExplicitRun(bare, settings, Path(folder), comm, overwrite)
        if written is not None:
            run.results.text(WRITTEN, written)
        return run.run()


class ExplicitRun:
    """One run: its problem, march, files and clock."""

    def __init__(self, scene: Scene, settings: Explicit, folder: Path, comm: MPI.Comm, overwrite: bool) -> None:
        self.scene, self.settings, self.comm, self.phases = scene, settings, comm, Phases()
        self.duration = scene.milestones[-1]
        self.progress, self.interruption = ProgressBar(self.duration, comm), Interruption(comm)
        self.problem = build_problem(scene, folder, overwrite, comm, self.progress, self.phases)
        with self.phases("forms"):
            self.measures = Measures(self.problem)
            self.differences = CentralDifferences(self.problem, settings, self.interruption.reason)
            energies = self.measures.state
            self.time_step = TimeStep(self.problem, self.differences.solve, energies, predicts=False)
        on_root(comm, lambda: prepare_folder(folder))
        self.results = Results(folder, self.problem, self.measures)
        self.results.text("scene.toml", self.problem.scene.to_toml())
        self.history: list[dict[str, float]] = []

    def run(self) -> Result:
        """March through all rows, then close all files."""
        ended = March()
        with self.progress, self.interruption:
            for start, end in self._rows():
                reason = self._advance(start, end)
                if reason is not None:
                    ended.stop(reason)
                    break
                ended.time, ended.steps = end, self.differences.steps
            if ended.ending is Ending.DONE:
                self._judge(ended)
            self._finish(ended)
        return Result(ended.ending is Ending.DONE, ended.reason, self.results.folder, self.history)

    def _rows(self) -> list[tuple[float, float]]:
        """Start and end in s of each row; rows end where pieces of the path do."""
        even = {self.duration * number / self.settings.rows for number in range(self.settings.rows)}
        apart = [time for time in even if min(abs(time - end) for end in self.scene.milestones) > 1e-9 * self.duration]
        ends = sorted({0.0, *apart, *self.scene.milestones})
        return list(pairwise(ends))

    def _advance(self, start: float, end: float) -> str | None:
        """March through a row and write it down; in words, why that failed."""
        self.problem.weight_share.value = min(end / (WEIGHING * self.duration), 1.0)
        with self.phases("march"):
            outcome = self.time_step.attempt(start, end - start)
        if not outcome.converged:
            return outcome.reason
        with self.phases("output"):
            measured = self.time_step.accept(lambda: self.measures.observe(self.differences.forces, end))
            cost = {"explicit_steps": outcome.iterations, "wall_time": self.phases.total}
            row = {"time": end, "time_step": end - start} | measured | self._energies(measured) | cost
            self.history.append(row)
            self.results.append(row)
        self.progress.show(row)
        return None

    def _energies(self, measured: dict[str, float]) -> dict[str, float]:
        copies, work = self.scene.stack.sides.copies, measured.get("tool_work", 0.0)
        kinetic, damped = copies * self.differences.kinetic_energy, copies * self.differences.damped
        energies = {"kinetic_energy": kinetic, "damped_share": damped / work if work > 0 else 0.0}
        internal = _internal_energy(measured | energies)
        return energies | {"kinetic_share": kinetic / internal if internal > 0 else float(kinetic > 0)}

    @property
    def kinetic_share(self) -> float:
        """Largest kinetic over internal energy, once that is no longer next to nothing."""
        internal = [_internal_energy(row) for row in self.history]
        least = EARLY * max(internal, default=0.0)
        pairs = zip(self.history, internal, strict=True)
        return float(max((row["kinetic_share"] for row, energy in pairs if energy >= least or least <= 0), default=0.0))

    def _judge(self, ended: March) -> None:
        """Whether the run was quasi-static."""
        share, limit = self.kinetic_share, self.settings.kinetic_share
        if share > limit:
            ended.stop(
                f"not quasi-static: the kinetic energy was up to {100 * share:.3g} % of the internal one; expected "
                f"{100 * limit:g} % at most: lower explicit.time_scaling or explicit.mass_scaling"
            )

    def _finish(self, ended: March) -> None:
        with self.phases("output"):
            if self.history:
                self.results.fields(ended.time)
        for caution in untouched(self.problem, self.history):
            self.progress.caution(caution)
        more = self._more() | wrinkle(self.problem, self.history, self.progress)
        self.results.record(record(self.problem, ended, self.phases, self.progress.cautions, more))
        if self.history:
            draw_closing_pictures(self.results, self.scene.output, self.progress, self.comm)

    def _more(self) -> dict[str, Any]:
        """What the record says of the march."""
        return {
            "explicit": {
                "steps": self.differences.steps,
                "kinetic_share": self.kinetic_share,
                "quasi_static": self.kinetic_share <= self.settings.kinetic_share,
                "lowest_period_s": math.tau / self.differences.lowest_frequency,
            }
        }


def _internal_energy(row: dict[str, float]) -> float:
    """Work of the tools in J that is neither kinetic energy nor damped, of a row of the history."""
    return row.get("tool_work", 0.0) * (1 - row["damped_share"]) - row["kinetic_energy"]
