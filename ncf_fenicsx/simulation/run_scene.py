"""The run of a scene: its results folder is claimed, its mesh found where it is automatic, then it is simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx.output.claim import Claim
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.automatic_mesh import CoarseRunEndedError, with_mesh_of_coarse_run
from ncf_fenicsx.simulation.run_record import Result
from ncf_fenicsx.simulation.simulation import Simulation


def run(
    scene: Scene,
    folder: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    overwrite: bool = False,
    restart: bool = False,
    written: str | None = None,
    bars: Mapping[str, float] | None = None,
    deadline: float = math.inf,
    claimed: bool = False,
) -> Result:
    """Run a scene on all ranks of ``comm`` and write its results.

    Args:
        scene: the case.
        folder: for results; made if it does not exist.
        comm: ranks that share the work.
        overwrite: whether results in the folder may be replaced.
        restart: whether to go on from the checkpoint in the folder, or from the start where it has none yet.
        written: text that the scene was read from, to be kept with the results.
        bars: error bars of columns of the history, over their size, to be shown with them.
        deadline: by the monotonic clock in s, at which the run stops with its last good state.
        claimed: whether the folder is the caller's already.

    Raises:
        SceneError: the scene's mesh is not valid, or the folder cannot be used; nothing has been written then.
        ResultError: results could not be written; what was written before stays.
    """
    folder = Path(folder)
    with nullcontext() if claimed else Claim(folder, comm, overwrite or restart):
        if scene.stack.is_automatic:
            try:
                scene, overwrite = with_mesh_of_coarse_run(scene, folder, comm), True
            except CoarseRunEndedError as ended:
                return ended.result
        return Simulation(scene, folder, comm, overwrite, restart, written, bars, deadline).run()
