"""The record of a run: how it ended, what it cost, and what computed it."""

from __future__ import annotations

import platform
import resource
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np

from ncf_fenicsx import solver
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.output.wrinkle_in_words import wrinkle_record
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.simulation.stepping import March
from ncf_fenicsx.solver.timing import Phases
from ncf_fenicsx.version import VERSION


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


def tolerances(problem: Problem) -> dict[str, float]:
    """What a solution had to hold."""
    settings = problem.scene.solver
    return {
        "unbalanced_force_over_support": settings.force_tolerance,
        "unbalanced_force_of_round_off_N": problem.scales.force_floor,
        "increment_m": settings.increment_tolerance * problem.scales.length,
    }


def untouched(problem: Problem, history: list[dict[str, float]]) -> list[str]:
    """Cautions on tools that never had a force in a history, each with where it ended; collective.

    Args:
        problem: what was solved.
        history: its rows.
    """
    cautions = []
    for number, tool in enumerate(problem.contacts.tools if history else ()):
        column = numbered("tool_force", number)
        if not any(row[column] for row in history):
            gap = tool.lowest_gap()
            cautions.append(f"{tool.name} never touched the stack: {column} is 0, and {1e3 * gap:.4g} mm are left")
    return cautions


def wrinkle(problem: Problem, history: list[dict[str, float]], progress: ProgressBar) -> dict[str, object]:
    """What the record says of the wrinkle that a run ends with, whose sentence is shown; nothing without a history."""
    found = wrinkle_record(problem.scene, history) if history else {}
    if found:
        progress.note(str(found["wrinkle"]))
    return found


def record(problem: Problem, ended: March, phases: Phases, cautions: list[str], more: dict[str, Any]) -> dict[str, Any]:
    """Contents of ``run.json``; collective.

    Args:
        problem: what was solved.
        ended: how the march through time ended.
        phases: clock of the run.
        cautions: what its user was told to mind.
        more: what else is to be told.
    """
    usage = resource.getrusage(resource.RUSAGE_SELF)
    memory, cpu = (problem.comm.allreduce(part) for part in (usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime))
    return {
        "title": problem.scene.title,
        "settings": problem.scene.table(),
        "ending": ended.ending.value,
        "reason": ended.reason,
        "time": ended.time,
        "steps": ended.steps,
        "cautions": cautions,
        **more,
        "unknowns": 3 * problem.space.dofmap.index_map.size_global,
        "cells": problem.mesh.topology.index_map(3).size_global,
        "ranks": problem.comm.size,
        "seconds": {name: round(value, 3) for name, value in sorted(phases.seconds.items())},
        "seconds_total": round(phases.total, 3),
        "seconds_cpu": round(cpu, 3),
        "peak_memory_mb": round(memory, 1),
        "versions": versions(),
        "command": shlex.join(sys.argv),
        "machine": f"{platform.node()}, {platform.machine()}",
    }


def versions() -> dict[str, str]:
    """Versions of what computed a result."""
    return {
        "ncf_fenicsx": VERSION,
        "dolfinx": dolfinx.__version__,
        "petsc": solver.petsc_version(),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }
