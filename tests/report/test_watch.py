"""A run is watched by its folder, until it has ended."""

import io
import shutil
import threading

import pytest
from program import call
from rich.console import Console

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.watch import steps, watch

pytestmark = pytest.mark.serial


def shown(table):
    console = Console(file=io.StringIO(), width=200)
    console.print(table)
    return console.file.getvalue()


def test_last_steps_are_those_of_the_history(results):
    read = Results.read(results)
    text = shown(steps(read))
    assert read.scene.title in text
    assert f"{read.history['tool_force'][-1]:.4g}" in text
    assert f"{read.history['vf_max'][-1]:.4g}" in text
    assert "Done at 12 s of 12 s" in text


def test_goes_on_until_the_run_has_ended(results, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    console = Console(file=io.StringIO(), width=200)
    thread = threading.Thread(target=watch, args=(folder, 0.05, console), daemon=True)
    thread.start()
    thread.join(0.3)
    for name in ("scene.toml", "history.csv"):
        shutil.copy(results / name, folder)
    thread.join(0.3)
    assert thread.is_alive()
    shutil.copy(results / "run.json", folder)
    thread.join(10)
    assert not thread.is_alive()
    assert "waiting for a run in" in console.file.getvalue()
    assert "Done at" in console.file.getvalue()


def test_the_command_ends_with_the_run(results, tmp_path):
    done = call("watch", results)
    assert done.returncode == 0
    assert "Done at 12 s of 12 s" in done.stdout
    with pytest.raises(SceneError, match="no such folder"):
        watch(tmp_path / "nothing", 1.0)
