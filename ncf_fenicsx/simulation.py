"""A scene from start to end: the only place that wires the rooms."""

from __future__ import annotations

import platform
import resource
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

import ncf_fenicsx
from ncf_fenicsx import solver
from ncf_fenicsx.measures import Measures
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.outputs import Results, check_folder, prepare_folder
from ncf_fenicsx.parallel import on_root
from ncf_fenicsx.problem import Problem
from ncf_fenicsx.progress import Progress
from ncf_fenicsx.report import draw_summary
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.solver import Newton, Outcome
from ncf_fenicsx.stepping import Ending, March, StepControl, march
from ncf_fenicsx.timing import Phases

SETTLING = StepControl(first=1.0, smallest=1e-3, largest=1.0, growth=2.0, cut=0.25, target_iterations=10, max_steps=200)
"""Shares of the weight, in place of time, for a stack that settles."""
SETTLING_PATIENCE = 4
"""Layers that bend by their weight part from each other row by row of nodes, one in each of Newton's iterations."""


@dataclass(frozen=True)
class Result:
    """How a run ended.

    Attributes:
        done: whether the end of the path was reached.
        reason: in words, why the run ended.
        folder: where its results are.
        history: rows of ``history.csv``.
    """

    done: bool
    reason: str
    folder: Path
    history: list[dict[str, float]]


def run(scene: Scene, folder: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, overwrite: bool = False) -> Result:
    """Run a scene on all ranks of ``comm`` and write its results.

    Args:
        scene: the case.
        folder: for results; made if it does not exist.
        comm: ranks that share the work.
        overwrite: whether results in the folder may be replaced.

    Raises:
        SceneError: the scene's mesh is not valid, or the folder cannot be used; nothing has been written then.
    """
    return Simulation(scene, Path(folder), comm, overwrite).run()


class Simulation:
    """One run: its problem, solver, files and clock."""

    def __init__(self, scene: Scene, folder: Path, comm: MPI.Comm, overwrite: bool) -> None:
        self.scene, self.comm, self.phases = scene, comm, Phases()
        self.milestones = scene.milestones
        self.progress = Progress(self.milestones[-1], comm)
        with self.phases("mesh"):
            stack = build_mesh(scene, comm)
        on_root(comm, lambda: check_folder(folder, overwrite))
        for caution in (*scene.cautions, *stack.cautions):
            self.progress.note(f"caution: {caution}")
        self.progress.note("compiling forms: seconds the first time, none after")
        with self.phases("forms"):
            self.problem = Problem(scene, stack)
            self.problem.contacts.check_start()
            self.measures = Measures(self.problem)
            self.newton = Newton(self.problem, scene.solver, self.phases)
        on_root(comm, lambda: prepare_folder(folder))
        self.results = Results(folder, self.problem, self.measures)
        self.results.text("scene.toml", scene.to_toml())
        self.history: list[dict[str, float]] = []
        self.iterations = 0
        self._cuts_before = 0

    def run(self) -> Result:
        """March through the path, then close all files."""
        with self.progress:
            ended = self.settle()
            if ended.ending is Ending.DONE:
                self.accept(March(), 0.0, self._settled)
                ended = march(step_control(self.scene), self.milestones, self.attempt, self.accept)
        self.finish(ended)
        return Result(ended.ending is Ending.DONE, ended.reason, self.results.folder, self.history)

    def settle(self) -> March:
        """Bring the stack to rest under its weight, in parts of it where all at once fails."""
        self._settled = Outcome(True, 0, "")
        ended = march(SETTLING, [1.0], self._settle_part, self._keep_part)
        if ended.ending is Ending.DONE:
            return ended
        return March().stop(f"the stack does not come to rest under its own weight: {ended.reason}")

    def _settle_part(self, carried: float, more: float) -> Outcome:
        """Try to carry more of the weight, as shares of it."""
        self.problem.weight_share.value = carried + more
        return self.attempt(0.0, 0.0, SETTLING_PATIENCE)

    def _keep_part(self, progress: March, more: float, outcome: Outcome) -> None:
        del more
        self._settled = self._settled.followed_by(outcome)
        if progress.time < 1.0:
            self.problem.commit(0.0)

    def attempt(self, time: float, size: float, patience: int = 1) -> Outcome:
        """Try a step, with a factor on Newton's iterations; one that fails leaves no trace."""
        self.problem.begin(time, size)
        outcome = self._solve(patience)
        self.iterations += outcome.iterations
        defect = self.problem.defect() if outcome.converged else None
        if defect is not None:
            outcome = Outcome(False, outcome.iterations, defect)
        if not outcome.converged:
            self.problem.rollback(time)
        return outcome

    def _solve(self, patience: int) -> Outcome:
        """Newton's method, again after each update of multipliers that a penetration above its tolerance asks for."""
        outcome, updates = self.newton.solve(patience), 0
        while outcome.converged and (augmented := self.problem.contacts.augment()) is not None:
            penetration, most = augmented
            updates += 1
            if updates > most:
                reason = f"penetration of {1e6 * penetration:.3g} um after {most} updates of the multipliers"
                return Outcome(False, outcome.iterations, reason)
            outcome = outcome.followed_by(self.newton.solve(patience))
        return outcome

    def accept(self, progress: March, size: float, outcome: solver.Outcome) -> None:
        """Commit a step, measure it and write it down."""
        with self.phases("output"):
            residual = self.newton.evaluate_residual()
            measured = self.measures.observe(residual)
            self.problem.commit(size)
            row = self._row(progress, size, outcome, measured)
            self.history.append(row)
            self.results.append(row)
            last = progress.time == self.milestones[-1]
            if progress.steps % self.scene.output.fields_every == 0 or last:
                self.results.fields(progress.time)
        self.progress.show(row)

    def finish(self, ended: March) -> None:
        """Write the last good state, the record of the run and the picture."""
        written = [time for time, _ in self.results.snapshots]
        with self.phases("output"):
            if self.history and self.comm.bcast(not written or written[-1] != ended.time):
                self.results.fields(ended.time)
        memory = self.comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
        self.results.record(self._record(ended, memory))
        if self.scene.output.picture and self.history:
            on_root(self.comm, lambda: draw_summary(self.results.folder))

    def _row(self, progress: March, size: float, outcome: Outcome, measured: dict[str, float]) -> dict[str, float]:
        when = {"time": progress.time, "time_step": size}
        cost = {
            "newton_iterations": outcome.iterations,
            "step_cuts": progress.cuts - self._cuts_before,
            "wall_time": self.phases.total,
        }
        self._cuts_before = progress.cuts
        return when | measured | cost

    def _record(self, ended: March, memory: float) -> dict[str, Any]:
        return {
            "title": self.scene.title,
            "settings": self.scene.table(),
            "ending": ended.ending.value,
            "reason": ended.reason,
            "time": ended.time,
            "steps": ended.steps,
            "step_cuts": ended.cuts,
            "newton_iterations": self.iterations,
            "unknowns": 3 * self.problem.space.dofmap.index_map.size_global,
            "cells": self.problem.mesh.topology.index_map(3).size_global,
            "ranks": self.comm.size,
            "seconds": {name: round(value, 3) for name, value in sorted(self.phases.seconds.items())},
            "seconds_total": round(self.phases.total, 3),
            "peak_memory_mb": round(memory, 1),
            "versions": versions(),
            "machine": f"{platform.node()}, {platform.machine()}",
        }


def step_control(scene: Scene) -> StepControl:
    """Step control of a scene, sizes that it does not name taken from its duration."""
    settings, duration = scene.solver, scene.milestones[-1]
    first = settings.first_step or duration / 30
    return StepControl(
        first=first,
        smallest=settings.smallest_step or first / 1e4,
        largest=settings.largest_step or duration / 8,
        growth=settings.growth,
        cut=settings.cut,
        target_iterations=settings.target_iterations,
        max_steps=settings.max_steps,
    )


def versions() -> dict[str, str]:
    """Versions of what computed a result."""
    return {
        "ncf_fenicsx": ncf_fenicsx.__version__,
        "dolfinx": dolfinx.__version__,
        "petsc": solver.petsc_version(),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }
