"""A scene from start to end: the only file that puts mesh, problem, solver, output and report together."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mpi4py import MPI

from ncf_fenicsx.mechanics.time_step import Outcome, TimeStep
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.checkpoint import Checkpoint
from ncf_fenicsx.output.measures import Measures
from ncf_fenicsx.output.results_folder import Results, prepare_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.scene_file import WRITTEN
from ncf_fenicsx.simulation.closing_pictures import draw_closing_pictures
from ncf_fenicsx.simulation.data_range import DataRange
from ncf_fenicsx.simulation.face_limits import FaceLimits
from ncf_fenicsx.simulation.interruption import Interruption
from ncf_fenicsx.simulation.loss_of_stability import LossOfStability
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.simulation.restart import goes_on
from ncf_fenicsx.simulation.run_record import Result, record, tolerances, untouched, wrinkle
from ncf_fenicsx.simulation.stabilisation import Stabilisation
from ncf_fenicsx.simulation.start import build_problem
from ncf_fenicsx.simulation.step import AugmentedNewton, Settling, StabilisedStep
from ncf_fenicsx.simulation.stepping import Ending, March, march, pieces
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.solver.timing import Phases


class Simulation:
    """One run: its problem, solver, files and clock."""

    def __init__(
        self,
        scene: Scene,
        folder: Path,
        comm: MPI.Comm,
        overwrite: bool,
        restart: bool = False,
        written: str | None = None,
        bars: Mapping[str, float] | None = None,
        deadline: float = math.inf,
    ) -> None:
        self.scene, self.comm, self.phases, self._written = scene, comm, Phases(), written
        self.milestones, self.pieces = scene.milestones, pieces(scene)
        self.progress = ProgressBar(self.milestones[-1], comm, bars)
        self.interruption = Interruption(comm, deadline)
        self._restarts = restart and on_root(comm, lambda: goes_on(folder, scene))
        if restart and not self._restarts and on_root(comm, (folder / "history.csv").is_file):
            self.progress.note("no checkpoint there yet: the run begins anew")
        self.problem = build_problem(scene, folder, overwrite or restart, comm, self.progress, self.phases)
        with self.phases("forms"):
            self.measures = Measures(self.problem)
            self.newton = Newton(self.problem, scene.solver, self.phases, self.interruption.reason)
            solver = AugmentedNewton(self.problem, self.newton)
            self.face_limits = FaceLimits(self.problem, self.measures.contacts.waves, self.progress)
            self.time_step = TimeStep(
                self.problem,
                solver.solve,
                self.measures.state,
                shape_violation=self.face_limits.violation,
            )
            self.stabilisation = Stabilisation.of_scene(scene)
            self.steps = StabilisedStep(self.time_step, self.stabilisation)
        self.results = Results(folder, self.problem, self.measures)
        self.stability = LossOfStability(
            self.newton, self.measures, self.results, self.progress, self.steps, self.interruption
        )
        self.data_range = DataRange(scene, self.progress)
        self.checkpoint = Checkpoint(folder, self.problem, self.time_step.state)
        self.history: list[dict[str, float]] = []
        self._cuts_before, self._seconds_before, self._saved_at = 0, 0.0, time.monotonic()

    def run(self) -> Result:
        """March through the path, then close all files."""
        saved = self._prepare()
        with self.progress, self.interruption:
            ended = self._start() if saved is None else self._resume(saved)
            if ended.ending is Ending.DONE:
                ended = march(
                    self.pieces,
                    self.steps.attempt,
                    self.accept,
                    ended,
                    self.problem.contacts.longest_step,
                )
            if self.interruption.request is not None:
                ended.stop(self.interruption.request)
            self.finish(ended)
        return Result(ended.ending is Ending.DONE, ended.reason, self.results.folder, self.history)

    def _prepare(self) -> dict[str, Any] | None:
        """Take the state of the checkpoint, if the run goes on from one; only when it fits is anything written."""
        saved = self.checkpoint.load() if self._restarts else None
        if saved is None:
            on_root(self.comm, lambda: prepare_folder(self.results.folder))
            if self._written is not None:
                self.results.text(WRITTEN, self._written)
        self.results.text("scene.toml", self.problem.scene.to_toml())
        return saved

    def _start(self) -> March:
        """The march at time 0, the stack at rest."""
        settling = Settling(self.steps)
        start = settling.run()
        if start.ending is Ending.DONE:
            start.size = math.inf
            self.accept(start, 0.0, settling.outcome)
        return start

    def accept(self, progress: March, size: float, outcome: Outcome) -> None:
        """Commit a step, measure it, write it down and save it where that is due."""
        with self.phases("output"):
            measured = self.time_step.accept(lambda: self._measure(progress.time, outcome))
            self.steps.held()
            self.stability.leave_branch()
            row = self._row(progress, size, outcome, measured)
            self.history.append(row)
            self.results.append(row)
            last = progress.time == self.milestones[-1]
            if progress.steps % self.scene.output.fields_every == 0 or last:
                self.results.fields(progress.time)
            self._save_if_due(progress)
        self.progress.show(row)

    def _measure(self, time: float, outcome: Outcome) -> dict[str, float]:
        """Measures of the trial state at a time (s); a loss of stability is noticed."""
        measured = self.measures.observe(self.newton.evaluate_residual(), time)
        self.data_range.watch(time, measured)
        self.face_limits.watch(time)
        self.stability.watch(time, outcome, measured.get("viscous_share", 0.0))
        return measured

    def finish(self, ended: March) -> None:
        """Write the last good state, the record of the run and the picture."""
        written = [time for time, _ in self.results.snapshots]
        with self.phases("output"):
            if self.history and self.comm.bcast(not written or written[-1] != ended.time):
                self.results.fields(ended.time)
            if self.history:
                self._save(ended)
        more = {"step_cuts": ended.cuts, "newton_iterations": self.steps.iterations, **self.stability.record()}
        more |= self.data_range.record()
        more |= {"factorisations": self.newton.linear.factorisations, "krylov_steps": self.newton.linear.krylov_steps}
        more["convergence"] = tolerances(self.problem)
        if self.history and "vf_error" in self.history[-1]:
            whole, plane = self.history[-1]["vf_error"], self.history[-1]["vf_error_in_plane"]
            more["estimated_error"] = {"vf_field": whole, "vf_field_in_plane": plane}
            parts = f"{100 * whole:.2g} %, in the plane of the layers {100 * plane:.2g} %"
            self.progress.note(f"estimated error of the field of Vf: {parts}")
        more |= wrinkle(self.problem, self.history, self.progress)
        for caution in untouched(self.problem, self.history):
            self.progress.caution(caution)
        self.results.record(record(self.problem, ended, self.phases, self.progress.cautions, more))
        if self.history:
            draw_closing_pictures(self.results, self.scene.output, self.progress, self.comm)

    def _save_if_due(self, progress: March) -> None:
        """Save a checkpoint where the scene's number of steps or its interval has passed since the last."""
        output, now = self.scene.output, time.monotonic()
        due = output.checkpoint_every is not None and progress.steps % output.checkpoint_every == 0
        if self.comm.bcast(due or now - self._saved_at >= output.checkpoint_interval):
            self._save(progress)

    def _save(self, progress: March) -> None:
        self.checkpoint.save(
            {
                "scene": self.scene.to_toml(),
                "time": progress.time,
                "size": progress.size,
                "steps": progress.steps,
                "cuts": progress.cuts,
                "fresh": progress.fresh,
                "iterations": self.steps.iterations,
                "cuts_before": self._cuts_before,
                "seconds": self._seconds,
                "rows": len(self.history),
                "snapshots": self.results.snapshots,
                "stability": self.stability.record(),
                "beyond_data": self.data_range.left,
                "cautions": self.progress.cautions,
                "viscosity": self.stabilisation.value,
                "wandered": self.steps.wandered,
                "piece": self.steps.piece,
            }
        )
        self._saved_at = time.monotonic()

    def _resume(self, saved: dict[str, Any]) -> March:
        """The march of the checkpoint whose state was taken, and its results."""
        self.time_step.resume(saved["time"])
        self.history = self.results.resume(saved["rows"], saved["snapshots"])
        self.steps.iterations, self._cuts_before = saved["iterations"], saved["cuts_before"]
        self.stability.recall(saved["stability"])
        self.data_range.left = saved["beyond_data"]
        self.progress.cautions += [words for words in saved.get("cautions", []) if words not in self.progress.cautions]
        self.stabilisation.value = saved["viscosity"]
        self.steps.wandered, self.steps.piece = saved.get("wandered", 0.0), saved.get("piece")
        self._seconds_before = saved["seconds"]
        self.progress.note(f"going on from {saved['time']:.6g} s")
        return March(**{name: saved[name] for name in ("time", "size", "steps", "cuts", "fresh")})

    @property
    def _seconds(self) -> float:
        """Wall time of the run in s, with what it took before it was restarted."""
        return self._seconds_before + self.phases.total

    def _row(self, progress: March, size: float, outcome: Outcome, measured: dict[str, float]) -> dict[str, float]:
        when = {"time": progress.time, "time_step": size}
        cost = {
            "newton_iterations": outcome.iterations,
            "step_cuts": progress.cuts - self._cuts_before,
            "wall_time": self._seconds,
        }
        self._cuts_before = progress.cuts
        stability = {} if outcome.negative_pivots is None else {"negative_pivots": outcome.negative_pivots}
        steps = {} if self.time_step.time_error is None else {"time_error": outcome.time_error}
        return when | measured | stability | steps | cost
