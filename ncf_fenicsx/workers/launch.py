"""A run of a study in processes of its own, so that the study goes on however it ends."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ncf_fenicsx.output.results_folder import ACCURACY
from ncf_fenicsx.report.reading import read_record

RECORD = "run.json"
BARE = ("output.picture=false", "output.report=false", "output.fields_every=1000000", "output.companion=false")
"""Overrides of a run that nobody looks at: its last fields, and no picture, page or companion."""
IN_TIME = 0.9
"""Share of the wall time of a run after which a sequence to an accuracy takes its best answer: the rest is for that."""


@dataclass(frozen=True)
class Ended:
    """How a run ended.

    Attributes:
        ending: done, stopped, time limit or error.
        reason: in words.
        folder: its results.
    """

    ending: str
    reason: str
    folder: Path

    @property
    def record(self) -> dict[str, Any]:
        """Its ``run.json``."""
        return read_record(self.folder)


def folder_name(case: str) -> str:
    """Name of the folder of a case in words."""
    return "".join(letter if letter.isalnum() else "_" for letter in case)


def launch(
    scene: Path,
    folder: Path,
    overrides: tuple[str, ...],
    limit: float,
    command: str = "run",
    ranks: int = 1,
    record: str = RECORD,
) -> Ended:
    """Run a scene file with some values replaced.

    Args:
        scene: the file.
        folder: for its results, replaced if it is there.
        overrides: ``key=value`` texts.
        limit: wall time in s after which it is ended.
        command: ``run`` or ``explicit``.
        ranks: processes that share the work.
        record: file of the folder that says how it ended.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    words = [sys.executable, "-m", "ncf_fenicsx", command, str(scene), "--out", str(folder), "--overwrite"]
    if command == "run":
        words += ["--ranks", str(ranks)]
    for text in overrides:
        words += ["--set", text]
    if ranks > 1:
        words = ["mpirun", "-n", str(ranks), *words]
    words = [*_dying_with_its_parent("TERM" if ranks > 1 else "KILL"), *words]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    try:
        ended = subprocess.run(words, capture_output=True, text=True, check=False, timeout=limit, env=environment)
    except subprocess.TimeoutExpired:
        return Ended("time limit", f"not done in {limit:g} s", folder)
    if ended.returncode not in (0, 1) or not (folder / record).is_file():
        last = ended.stderr.strip().splitlines()
        return Ended("error", last[-1] if last else f"exit code {ended.returncode}", folder)
    written = json.loads((folder / record).read_text("utf-8"))
    return Ended(written["ending"], written.get("reason", ""), folder)


def launch_levels(
    scene: Path, folder: Path, overrides: tuple[str, ...], limit: float, ranks: int = 1
) -> tuple[Ended, dict[str, Any]]:
    """Run a scene file by levels to an accuracy; how that ended, and its ``accuracy.json``, empty where it has none.

    Args:
        scene: the file.
        folder: for its results, replaced if it is there.
        overrides: ``key=value`` texts.
        limit: wall time in s after which it is ended.
        ranks: processes that share the work.
    """
    in_time = f"accuracy.most_time={IN_TIME * limit} s"
    ended = launch(scene, folder, (*overrides, in_time), limit, ranks=ranks, record=ACCURACY)
    path = folder / ACCURACY
    return ended, json.loads(path.read_text("utf-8")) if path.is_file() else {}


def _dying_with_its_parent(signal: str) -> list[str]:
    """Words before a command that end it with the process that started it, however that dies, where the system can.

    A run that outlived its study would still write to a folder that the next one takes for its own.
    """
    return ["setpriv", "--pdeathsig", signal] if shutil.which("setpriv") else []
