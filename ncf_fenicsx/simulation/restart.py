"""Whether a run can go on from what its folder holds."""

from __future__ import annotations

import tomllib
from pathlib import Path

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.checkpoint import NAME, read_progress
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.changes import check_changes


def goes_on(folder: Path, scene: Scene) -> bool:
    """Whether a run goes on from the checkpoint in a folder; it begins anew where there is none. Nothing is written.

    Raises:
        SceneError: no run goes on with what is there, or not as this scene.
    """
    if not (folder / NAME).is_file():
        _check_begins(folder)
        return False
    saved = read_progress(folder / NAME)
    try:
        old = Scene.from_table(tomllib.loads(saved["scene"]))
    except (KeyError, SceneError) as error:
        raise SceneError(f"{folder / NAME}: of another version; expected a checkpoint of this one") from error
    check_changes(old, scene, saved["time"], str(folder))
    return True


def _check_begins(folder: Path) -> None:
    """Refuse the results of an explicit march, which no run goes on with."""
    history = folder / "history.csv"
    if history.is_file() and "explicit_steps" in history.read_text(encoding="utf-8").partition("\n")[0]:
        raise SceneError(f"{folder}: results of an explicit march, which has no checkpoints; expected those of a run")
