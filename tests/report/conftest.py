"""Results that the tests of pages read: one small run with all that a page can show, and a browser."""

import json
import shutil

import pytest
import tomli_w
from browser import opened
from scenes_of_pages import WHOLE

from ncf_fenicsx import Scene, run
from ncf_fenicsx.scene.scene_file import as_written


@pytest.fixture(scope="session")
def results(tmp_path_factory):
    """Results folder of a run that has ended, with its page."""
    folder = tmp_path_factory.mktemp("report")
    file = folder / "scene.toml"
    file.write_text(tomli_w.dumps(WHOLE), encoding="utf-8")
    changes = ["solver.largest_step='2 s'"]
    run(Scene.read(file, changes), folder / "run", written=as_written(file, changes))
    return folder / "run"


@pytest.fixture
def copied(results, tmp_path):
    """A copy of that folder, to be changed."""
    return shutil.copytree(results, tmp_path / "copy")


@pytest.fixture
def other(copied):
    """Another run to compare with: that copy, as if it had been pressed by more."""
    scene = copied / "scene.toml"
    scene.write_text(scene.read_text("utf-8").replace("-0.0002 m", "-0.0003 m"), encoding="utf-8")
    record = json.loads((copied / "run.json").read_text("utf-8"))
    (copied / "run.json").write_text(json.dumps(record | {"reason": "another"}), encoding="utf-8")
    return copied


@pytest.fixture(scope="session")
def browser():
    """One browser for all tests of a process."""
    with opened() as started:
        yield started
