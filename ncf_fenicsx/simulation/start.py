"""How every run begins: the mesh of its scene, what a user has to know of both, the problem."""

from __future__ import annotations

from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import check_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.solver.timing import Phases

LEAST_FORCE = 100.0
"""Least force on a tool over the forces that round-off leaves: it is then carried to 0.1 %."""


def build_problem(
    scene: Scene, folder: Path, overwrite: bool, comm: MPI.Comm, progress: ProgressBar, phases: Phases
) -> Problem:
    """The problem of a scene whose results go to a folder.

    Args:
        scene: the case.
        folder: for results; nothing is written yet.
        overwrite: whether results in it may be replaced.
        comm: ranks that share the work.
        progress: tells cautions, and what takes time.
        phases: clock that mesh and forms are booked on.

    Raises:
        SceneError: the scene's mesh is not valid, a tool starts in the stack, never meets it or has a force that is
            lost in round-off, or the folder cannot be used.
    """
    with phases("mesh"):
        stack = build_mesh(scene, comm)
    on_root(comm, lambda: check_folder(folder, overwrite))
    for caution in (*scene.cautions, *stack.cautions):
        progress.caution(caution)
    progress.note("compiling forms: seconds the first time, none after")
    with phases("forms"):
        problem = Problem(scene, stack)
        problem.contacts.check_start()
        check_forces(problem)
    return problem


def check_forces(problem: Problem) -> None:
    """Whether round-off leaves of the forces on tools what a height can be found by; collective.

    Raises:
        SceneError: a force is too small.
    """
    least = LEAST_FORCE * problem.scales.force_floor
    for control in problem.contacts.controls:
        for number, segment in enumerate(control.path):
            if segment.force is not None and segment.force < control.copies * least:
                raise SceneError(
                    f"{control.contact.name}.path.{number}.force = {segment.force:.4g} N: below what round-off leaves "
                    f"of the forces in this mesh; expected at least {control.copies * least:.2g} N"
                )
