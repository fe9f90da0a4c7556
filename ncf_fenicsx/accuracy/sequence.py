"""Runs of a scene, each level finer than the last, until error bars are as small as asked, or cost ends it."""

from __future__ import annotations

import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from mpi4py import MPI

from ncf_fenicsx import simulation
from ncf_fenicsx.accuracy.answer import Answer, Level
from ncf_fenicsx.accuracy.companion import companion_in_words, companion_of, run_companion
from ncf_fenicsx.accuracy.cost import Cost, duration, expected
from ncf_fenicsx.accuracy.levels import BELOW, Levels, learn, levels_of
from ncf_fenicsx.accuracy.quantities import check_quantities
from ncf_fenicsx.accuracy.record import show_in_finest, write_answer
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.output.claim import Claim
from ncf_fenicsx.output.results_folder import FILES, FOLDERS
from ncf_fenicsx.report.reading import read_rows
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.scene_file import WRITTEN, read_table
from ncf_fenicsx.scene.settings import Accuracy
from ncf_fenicsx.simulation.interruption import was_asked_to_end
from ncf_fenicsx.simulation.ranks import free_memory
from ncf_fenicsx.simulation.run_record import Result
from ncf_fenicsx.terminal import say

FEWEST = 3
"""Levels before which no bar is believed: two may agree by chance."""
SHARE_OF_FREE = 0.8
"""Share of the free memory that a level may take unless the scene says how much."""


def run(
    scene: Scene,
    folder: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    overwrite: bool = False,
    restart: bool = False,
    written: str | None = None,
) -> Result:
    """Run a scene on all ranks of ``comm``; where it asks for an accuracy, run its levels until it is reached.

    Args:
        scene: the case.
        folder: for results; made if it does not exist. Those of levels are in ``level_0`` and so on in it.
        comm: ranks that share the work.
        overwrite: whether results in the folder may be replaced.
        restart: whether to go on with what the folder holds.
        written: text that the scene was read from, to be kept with the results.

    Returns:
        How the run ended, or the sequence; then with folder and history of its last level that was done.

    Raises:
        SceneError: the scene cannot be run, or not with this accuracy, or the folder cannot be used; nothing has been
            written then.
        ResultError: results could not be written; what was written before stays.
    """
    if scene.accuracy is None:
        return _run_alone(scene, Path(folder), comm, overwrite, restart, written)
    sequence = Sequence(scene, scene.accuracy, Path(folder), comm)
    with Claim(Path(folder), comm, overwrite or restart):
        on_root(comm, lambda: sequence.prepare(restart, written))
        return sequence.run()


def _run_alone(
    scene: Scene, folder: Path, comm: MPI.Comm, overwrite: bool, restart: bool, written: str | None
) -> Result:
    """One run, and its companion after it where the scene asks for one."""
    if not scene.output.companion:
        return simulation.run(scene, folder, comm, overwrite, restart, written)
    companion_of(scene)
    with Claim(folder, comm, overwrite or restart):
        result = simulation.run(scene, folder, comm, overwrite, restart, written, claimed=True)
        return run_companion(scene, result, comm, restart) if result.done else result


def plan(scene: Scene) -> list[str]:
    """What the levels of a scene that asks for an accuracy, or its companion, are expected to cost, in lines.

    Raises:
        SceneError: the scene has no such quantity or cannot be refined.
    """
    accuracy = scene.accuracy
    if accuracy is None:
        return [companion_in_words(scene)] if scene.output.companion else []
    levels, first = checked_levels(scene, accuracy)
    lines = [f"accuracy: {', '.join(accuracy.quantities)} to {100 * accuracy.tolerance:.3g} %, by levels"]
    for level in range(first, first + FEWEST + 1):
        lines.append(f"  level {level}: {levels.words(level)}: about {expected(levels[level], []).words}")
    lines.append(f"  {FEWEST} levels at least, finer ones if needed, in {duration(accuracy.most_time)} at most")
    return lines


def checked_levels(scene: Scene, accuracy: Accuracy) -> tuple[Levels, int]:
    """The levels of a scene, and which is the coarsest that can be run.

    Raises:
        SceneError: the scene has no such quantity, cannot be refined, not even its own mesh can be run, or a
            companion is asked for too.
    """
    if scene.output.companion:
        raise SceneError("output.companion = true: expected false with [accuracy], whose levels tell more")
    check_quantities(scene, accuracy.quantities)
    levels = levels_of(scene, "accuracy")
    size_of(levels[BELOW])
    for level in range(BELOW):
        with suppress(SceneError):
            size_of(levels[level])
            return levels, level
    return levels, BELOW


class Sequence:
    """The levels of one scene: which has run, what they tell, which comes next.

    Args:
        scene: that asks for an accuracy.
        accuracy: what it asks for.
        folder: for results.
        comm: ranks of all runs.

    Raises:
        SceneError: the scene has no such quantity, cannot be refined or cannot be run.
    """

    def __init__(self, scene: Scene, accuracy: Accuracy, folder: Path, comm: MPI.Comm) -> None:
        self.scene, self.accuracy, self.folder, self.comm = scene, accuracy, folder, comm
        self.levels, self.first = checked_levels(scene, accuracy)
        self.answer = Answer(accuracy.quantities, accuracy.tolerance)
        self._skipped = 0.0
        self._memory = accuracy.most_memory or comm.bcast(SHARE_OF_FREE * free_memory())

    def prepare(self, restart: bool, written: str | None) -> None:
        """Make the folder ready; on rank 0.

        Raises:
            SceneError: it is to go on, but with another scene.
        """
        if restart:
            self._check_same()
        else:
            for path in (*self.folder.glob("level_[0-9]*"), *(self.folder / name for name in ("fields", *FOLDERS))):
                shutil.rmtree(path, ignore_errors=True)
            for name in FILES:
                (self.folder / name).unlink(missing_ok=True)
        if written is not None and not restart:
            (self.folder / WRITTEN).write_text(written, encoding="utf-8")
        (self.folder / "scene.toml").write_text(self.scene.to_toml(), encoding="utf-8")

    def _check_same(self) -> None:
        """Whether the levels in the folder are of this scene."""
        old = Scene.from_table(read_table(self.folder / "scene.toml")).table()
        new = Scene.from_table(self.scene.table()).table()
        for key in sorted((old.keys() | new.keys()) - {"accuracy", "title"}):
            if old.get(key) != new.get(key):
                words = "expected it as it was: only [accuracy] may change where levels are to go on"
                raise SceneError(f"{self.folder}: {key}: {words}")

    def run(self) -> Result:
        """Run levels from the coarsest on."""
        say("\n".join(plan(self.scene)))
        level, done, history = self.first, False, []
        while True:
            reason = self._too_much(level)
            if reason is None:
                ended = self._run_level(level)
                if not ended.done and self._may_skip(level, ended.reason):
                    level += 1
                    continue
                if not ended.done:
                    reason = f"level {level}: {ended.reason}"
            if reason is not None:
                break
            history = ended.history
            self._take(level)
            if self.answer.met and len(self.answer.levels) >= FEWEST:
                done, reason = True, f"all error bars are inside {100 * self.accuracy.tolerance:.3g} %"
                break
            level += 1
        return self._finish(done, reason, history)

    def _folder_of(self, level: int) -> Path:
        return self.folder / f"level_{level}"

    @property
    def _spent(self) -> float:
        """Wall time in s of all levels so far."""
        return self._skipped + sum(level.wall for level in self.answer.levels)

    def _may_skip(self, level: int, reason: str) -> bool:
        """Whether a level that has stopped early was just too coarse, by why it did: the sequence begins after it."""
        if level >= BELOW or was_asked_to_end(reason):
            return False
        say(f"level {level} is too coarse for this scene: levels begin after it")
        self._skipped = self._spent + on_root(self.comm, lambda: Level.wall_before(self._folder_of(level)))
        self.answer = Answer(self.accuracy.quantities, self.accuracy.tolerance)
        return True

    def _too_much(self, level: int) -> str | None:
        """In words, why a level is not to be run; None if it may."""
        cost = expected(self.levels[level], self._costs)
        if self._is_done(level):
            return None
        left = self.accuracy.most_time - self._spent
        if cost.memory > self._memory:
            return f"level {level} would need {cost.memory / 1e9:.2g} GB, of {self._memory / 1e9:.2g} GB (most_memory)"
        if left <= 0 or (self.answer.levels and cost.seconds > left):
            words = (
                f"would take about {duration(cost.seconds)}, of {duration(max(left, 0.0))} that are left (most_time)"
            )
            return f"level {level} {words}"
        say(f"\nlevel {level}: {self.levels.words(level)}: about {cost.words}")
        return None

    @property
    def _costs(self) -> list[Cost]:
        return [level.cost for level in self.answer.levels]

    def _is_done(self, level: int) -> bool:
        return bool(on_root(self.comm, lambda: Level.is_done(self._folder_of(level))))

    def _run_level(self, level: int) -> Result:
        """Run a level, go on with it where it was killed, or take it as it is where it is done."""
        folder = self._folder_of(level)
        if self._is_done(level):
            return Result(True, "done before", folder, on_root(self.comm, lambda: read_rows(folder)))
        quiet = {"picture": False, "report": False}
        scene = self.levels[level]
        scene = scene.model_copy(update={"output": scene.output.model_copy(update=quiet)})
        before = on_root(self.comm, lambda: Level.wall_before(folder))
        deadline = time.monotonic() + self.accuracy.most_time - self._spent - before
        bars = self.answer.expected_bars
        return simulation.run(
            Scene.from_table(scene.table()), folder, self.comm, restart=True, bars=bars, deadline=deadline
        )

    def _take(self, level: int) -> None:
        """Take the results of a level that is done, and say what all tell by now."""
        self.answer = on_root(self.comm, lambda: self.answer.with_level(level, self._folder_of(level), self.scene))
        if len(self.answer.levels) == 1:
            flat = on_root(self.comm, lambda: learn(self.scene, self._folder_of(level)))
            self.levels = Levels(self.scene, flat)
        on_root(self.comm, lambda: self._write(None))
        say("\n".join(self.answer.lines))

    def _write(self, ending: tuple[bool, str] | None) -> dict[str, Any]:
        return write_answer(self.folder, self.answer, self.accuracy, ending)

    def _finish(self, done: bool, reason: str, history: list[dict[str, float]]) -> Result:
        """Write the answer, show it in the results of the finest level that is done."""
        folder = self.folder
        if self.answer.levels:
            folder = self.answer.levels[-1].folder
            record = on_root(self.comm, lambda: self._write((done, reason)))
            for words in on_root(self.comm, lambda: show_in_finest(self.answer, record, self.scene.output)):
                say(f"caution: {words}")
            say("\n" + "\n".join(self.answer.lines))
        return Result(done, reason, folder, history)
