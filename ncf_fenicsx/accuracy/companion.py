"""The companion of a run: half its mesh, at a tenth of its cost, tells how far its numbers may be off."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx import simulation
from ncf_fenicsx.accuracy.answer import Answer, Level
from ncf_fenicsx.accuracy.cost import expected
from ncf_fenicsx.accuracy.levels import Levels, levels_of
from ncf_fenicsx.accuracy.quantities import FIELD, quantities_of
from ncf_fenicsx.accuracy.record import add_caution, show_of_companion
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.output.results_folder import COMPANION
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.interruption import was_asked_to_end
from ncf_fenicsx.simulation.run_record import Result
from ncf_fenicsx.terminal import say

KEY = "output.companion"


def companion_of(scene: Scene) -> Scene:
    """The scene of a companion: half as many elements along each axis, steps twice as long, all else as it is.

    Raises:
        SceneError: the scene's mesh cannot be halved.
    """
    companion = levels_of(scene, KEY, below=1).coarsened(0)
    if size_of(companion).unknowns == size_of(scene).unknowns:
        divisions = json.dumps(scene.stack.divisions)
        raise SceneError(f"{KEY}: stack.divisions = {divisions}: expected two elements or more along x or y")
    bare = {"companion": False, "picture": False, "report": False}
    return companion.model_copy(update={"output": scene.output.model_copy(update=bare)})


def companion_in_words(scene: Scene) -> str:
    """What the companion of a scene is, and is expected to cost, in words."""
    companion = companion_of(scene)
    return f"companion: {Levels(scene, below=1).words(0)}: about {expected(companion, []).words}"


def run_companion(scene: Scene, result: Result, comm: MPI.Comm, restart: bool) -> Result:
    """Run the companion of a run that is done, and show the errors that both tell with the results of the run.

    Args:
        scene: of the run.
        result: of the run.
        comm: ranks that share the work.
        restart: whether the companion goes on with what its folder holds.

    Returns:
        The result of the run; not done, where the companion was asked to end.

    Raises:
        ResultError: results could not be written; what was written before stays.
    """
    say(companion_in_words(scene))
    folder = result.folder / COMPANION
    try:
        ended = simulation.run(companion_of(scene), folder, comm, overwrite=True, restart=restart)
    except SceneError as error:
        ended = Result(False, str(error), folder, [])
    if not ended.done:
        words = f"no errors are told, as the companion stopped: {ended.reason}"
        say(f"caution: {words}")
        on_root(comm, lambda: add_caution(result.folder, words))
        return replace(result, done=False, reason=words) if was_asked_to_end(ended.reason) else result
    answer = on_root(comm, lambda: _answer(scene, folder, result.folder))
    for words in on_root(comm, lambda: show_of_companion(answer, scene.output)):
        say(f"caution: {words}")
    say("\n" + "\n".join(answer.lines))
    return result


def _answer(scene: Scene, companion: Path, own: Path) -> Answer:
    """What both runs tell of the quantities that are not none; of the field of Vf each run has an estimate itself."""
    has = quantities_of(scene)
    names = tuple(name for name in has if has[name] and name != FIELD)
    levels = (Level.read(0, companion, names), Level.read(1, own, names))
    return Answer(tuple(name for name in names if any(level.values[name] for level in levels)), 1.0, levels)
