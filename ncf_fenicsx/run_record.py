"""The record of a run: how it ended, what it cost, and what computed it."""

from __future__ import annotations

import platform
import resource
from typing import Any

import dolfinx
import numpy as np

import ncf_fenicsx
from ncf_fenicsx import solver
from ncf_fenicsx.problem import Problem
from ncf_fenicsx.stepping import March
from ncf_fenicsx.timing import Phases


def record(
    problem: Problem, ended: March, iterations: int, phases: Phases, stability: dict[str, Any]
) -> dict[str, Any]:
    """Contents of ``run.json``; collective.

    Args:
        problem: what was solved.
        ended: how the march through time ended.
        iterations: Newton iterations, those of failed steps included.
        phases: clock of the run.
        stability: when the run lost it first, and from when on a viscosity has steadied it.
    """
    solver_settings = problem.scene.solver
    memory = problem.comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    return {
        "title": problem.scene.title,
        "settings": problem.scene.table(),
        "ending": ended.ending.value,
        "reason": ended.reason,
        "time": ended.time,
        "steps": ended.steps,
        "step_cuts": ended.cuts,
        "newton_iterations": iterations,
        **stability,
        "convergence": {
            "unbalanced_force_over_support": solver_settings.force_tolerance,
            "unbalanced_force_of_round_off_N": problem.force_floor,
            "increment_m": solver_settings.increment_tolerance * problem.length,
        },
        "unknowns": 3 * problem.space.dofmap.index_map.size_global,
        "cells": problem.mesh.topology.index_map(3).size_global,
        "ranks": problem.comm.size,
        "seconds": {name: round(value, 3) for name, value in sorted(phases.seconds.items())},
        "seconds_total": round(phases.total, 3),
        "peak_memory_mb": round(memory, 1),
        "versions": versions(),
        "machine": f"{platform.node()}, {platform.machine()}",
    }


def versions() -> dict[str, str]:
    """Versions of what computed a result."""
    return {
        "ncf_fenicsx": ncf_fenicsx.__version__,
        "dolfinx": dolfinx.__version__,
        "petsc": solver.petsc_version(),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }
