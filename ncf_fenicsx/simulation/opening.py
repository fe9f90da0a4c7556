"""How every run begins: the scene's mesh, what a user has to know of both, the problem."""

from __future__ import annotations

from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import check_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.progress_bar import Progress
from ncf_fenicsx.solver.timing import Phases


def open_problem(
    scene: Scene, folder: Path, overwrite: bool, comm: MPI.Comm, progress: Progress, phases: Phases
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
        SceneError: the scene's mesh is not valid, a tool starts in the stack, or the folder cannot be used.
    """
    with phases("mesh"):
        stack = build_mesh(scene, comm)
    on_root(comm, lambda: check_folder(folder, overwrite))
    for caution in (*scene.cautions, *stack.cautions):
        progress.note(f"caution: {caution}")
    progress.note("compiling forms: seconds the first time, none after")
    with phases("forms"):
        problem = Problem(scene, stack)
        problem.contacts.check_start()
    return problem
