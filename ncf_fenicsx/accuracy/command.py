"""``ncf-fenicsx run``: what is asked for is checked on one process, before ranks are started or anything is written."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx.accuracy.companion import companion_of
from ncf_fenicsx.accuracy.cost import expected
from ncf_fenicsx.accuracy.sequence import FEWEST, checked_levels, run
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.coarse_grid import coarse_scene
from ncf_fenicsx.mesh.memory import expected_memory
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.output.results_folder import check_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.scene_file import as_written
from ncf_fenicsx.simulation.ranks import is_launched, ranks_that_pay, run_on
from ncf_fenicsx.terminal import say


@dataclass(frozen=True)
class Order:
    """What the command line asks for.

    Attributes:
        file: of the scene; None to go on.
        out: folder for the results; None for the usual one.
        overrides: ``key=value`` texts.
        overwrite: whether results may be replaced.
        restart: folder of results to go on with; None to begin.
        accuracy: keys of ``[accuracy]`` as texts; None for what the scene says.
        companion: whether half the mesh is to be run too; False for what the scene says.
        ranks: processes; None for as many as pay.
    """

    file: Path | None
    out: Path | None
    overrides: tuple[str, ...]
    overwrite: bool
    restart: Path | None
    accuracy: dict[str, str | None]
    companion: bool
    ranks: int | None

    @property
    def source(self) -> Path:
        """File that the scene is read from."""
        self._check()
        return self.file if self.file is not None else self.folder / "scene.toml"

    @property
    def folder(self) -> Path:
        """Folder for the results."""
        self._check()
        if self.restart is not None:
            return self.restart
        return self.out or Path("results") / str(self.file and self.file.stem)

    @property
    def changes(self) -> tuple[str, ...]:
        """All that replaces values of the scene."""
        asked = ((name, text) for name, text in self.accuracy.items() if text is not None)
        companion = ("output.companion=true",) if self.companion else ()
        return (*self.overrides, *companion, *(f"accuracy.{name}='{text}'" for name, text in asked))

    def _check(self) -> None:
        begins = self.file is not None and self.restart is None
        goes_on = self.restart is not None and self.file is None and self.out is None and not self.overwrite
        if not begins and not goes_on:
            raise SceneError("run: expected either a scene file, with --out and --overwrite, or --restart FOLDER alone")


def carry_out(order: Order) -> int:
    """Run what is asked for; the exit code: 0 done, 1 stopped early.

    Raises:
        SceneError: something asked for is wrong; nothing is written then.
        ResultError: results could not be written.
    """
    scene = Scene.read(order.source, order.changes)
    if is_launched():
        _check_ranks(order.ranks)
    else:
        ranks = order.ranks or _ranks_that_pay(scene)
        if ranks > 1:
            _check(scene, order)
            return run_on(ranks, sys.argv[1:])
    written = as_written(order.source, order.changes)
    goes_on = order.restart is not None
    result = run(scene, order.folder, overwrite=order.overwrite, restart=goes_on, written=written)
    say(f"{'done' if result.done else 'stopped'}: {result.reason}; results in {result.folder}")
    return 0 if result.done else 1


def _check_ranks(asked: int | None) -> None:
    """Under a launcher the number of ranks is the launcher's."""
    from mpi4py import MPI

    if asked not in (None, MPI.COMM_WORLD.size):
        raise SceneError(f"--ranks {asked}: mpirun has started {MPI.COMM_WORLD.size}; expected only one of both")


def _ranks_that_pay(scene: Scene) -> int:
    """Ranks for a scene, or for the finest level that it needs at least; said where it is more than one."""
    if scene.accuracy is None:
        scene = coarse_scene(scene) if scene.stack.is_automatic else scene
        unknowns = size_of(scene).unknowns
        memory = 1e9 * expected_memory(scene, unknowns)
    else:
        levels, _ = checked_levels(scene, scene.accuracy)
        cost = expected(levels[FEWEST - 1], [])
        unknowns, memory = cost.unknowns, cost.memory
    ranks = ranks_that_pay(unknowns, memory)
    if ranks > 1:
        print(f"{unknowns:,} unknowns: on {ranks} ranks (--ranks N for another number)", flush=True)
    return ranks


def _check(scene: Scene, order: Order) -> None:
    """What every rank would refuse, refused once."""
    size_of(coarse_scene(scene) if scene.stack.is_automatic else scene)
    check_folder(order.folder, order.overwrite or order.restart is not None)
    if scene.accuracy is not None:
        checked_levels(scene, scene.accuracy)
    elif scene.output.companion:
        companion_of(scene)
