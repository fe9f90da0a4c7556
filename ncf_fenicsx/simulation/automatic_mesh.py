"""A mesh that follows the solution: nodes are placed by the estimated error of a coarse run, over all of its path."""

from __future__ import annotations

import math
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.time_step import Outcome
from ncf_fenicsx.mesh.coarse_grid import coarse_scene, on_nodes
from ncf_fenicsx.mesh.equidistribution import cheapest, constant_of, error_of, placed
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.mesh_indicator import MeshIndicator
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.interruption import was_asked_to_end
from ncf_fenicsx.simulation.run_record import Result
from ncf_fenicsx.simulation.simulation import Simulation

Floats = NDArray[np.float64]

FOLDER = "coarse_run"
"""Where in a results folder the coarse run is kept."""
CORRECTIONS = 4
LEAST = 0.01
"""Error that a mesh is taken to have at least, over what is wanted."""
BARE = {"picture": False, "report": False, "fields_every": 1_000_000}
"""What nobody looks at of a coarse run is not written."""


class CoarseRunEndedError(Exception):
    """A coarse run was asked to end, so that its mesh would be that of half a path.

    Attributes:
        result: of the coarse run, with its reason.
    """

    def __init__(self, result: Result) -> None:
        super().__init__(result.reason)
        self.result = result


class CoarseRun(Simulation):
    """A run that watches where its mesh is too coarse."""

    def __init__(self, scene: Scene, folder: Path, comm: MPI.Comm) -> None:
        super().__init__(scene, folder, comm, overwrite=True)
        assert self.measures.error is not None
        assert scene.stack.nodes is not None
        x, y = (np.array(positions) for positions in scene.stack.nodes)
        error = self.measures.error
        self.indicator = MeshIndicator(self.problem, error.recovery, (x, y), error.volumes)

    def _measure(self, time: float, outcome: Outcome) -> dict[str, float]:
        measured = super()._measure(time, outcome)
        self.indicator.watch(self.measures.cells["volume_fraction"])
        return measured


def with_mesh_of_coarse_run(scene: Scene, folder: Path, comm: MPI.Comm) -> Scene:
    """A scene with nodes that share out the error of the field of Vf evenly, by a coarse run; collective.

    Args:
        scene: with automatic divisions.
        folder: of the results, which takes those of the coarse run too.
        comm: ranks that share the work.

    Raises:
        CoarseRunEndedError: by a signal.
        SceneError: as of every run.
    """
    output = scene.output.model_copy(update=BARE)
    coarse = coarse_scene(scene).model_copy(update={"output": output})
    run = CoarseRun(coarse, folder / FOLDER, comm)
    run.progress.note(f"coarse run for the mesh: {_shown(coarse)}")
    result = run.run()
    if was_asked_to_end(result.reason):
        raise CoarseRunEndedError(replace(result, reason=f"coarse run for the mesh: {result.reason}"))
    found = with_nodes_of(scene, run.indicator)
    if not result.done:
        run.progress.note(f"caution: the coarse run stopped, {result.reason}; the mesh follows what it has seen")
    run.progress.note(f"mesh for an error of {100 * scene.stack.mesh_error:.3g} % in the plane: {_shown(found)}")
    return found


def with_mesh_in_advance(scene: Scene, comm: MPI.Comm) -> Scene:
    """The scene on the mesh that a run of it would take, by the same coarse run, of which nothing is kept; collective.

    Raises:
        CoarseRunEndedError: by a signal.
        SceneError: as of every run.
    """
    place = Path(on_root(comm, tempfile.mkdtemp))
    try:
        return with_mesh_of_coarse_run(scene, place, comm)
    finally:
        if comm.rank == 0:
            shutil.rmtree(place, ignore_errors=True)


def with_nodes_of(scene: Scene, indicator: MeshIndicator) -> Scene:
    """The scene on the mesh that an indicator asks for.

    Raises:
        SceneError: the fabric has not changed, so nothing can be asked for.
    """
    if indicator.change <= 0:
        raise SceneError('stack.divisions = "automatic": Vf did not change in the coarse run; expected two numbers')
    lines, wanted = indicator.lines, scene.stack.mesh_error * math.sqrt(indicator.change)
    ever = [np.max(squares, axis=0) for squares in zip(*indicator.squares, strict=True)]
    constants = [constant_of(*axis) for axis in zip(lines, ever, strict=True)]
    error = wanted
    for _ in range(CORRECTIONS):  # no time has all that is off at any time, and elements grow slower than is ideal
        counts = cheapest((constants[0], constants[1]), error)
        nodes = [placed(*axis) for axis in zip(lines, ever, counts, strict=True)]
        found = max(_error(lines, squares, nodes) for squares in indicator.squares)
        error *= wanted / max(found, LEAST * wanted)
    return on_nodes(scene, *nodes)


def _shown(scene: Scene) -> str:
    (x, y), *_ = scene.stack.divisions_by_layer
    return f"{x} x {y} elements a layer"


def _error(lines: tuple[Floats, Floats], squares: tuple[Floats, Floats], nodes: list[Floats]) -> float:
    """Root mean square error of a mesh at one time, along both axes."""
    return math.hypot(*(error_of(*axis) for axis in zip(lines, squares, nodes, strict=True)))
