"""Commands in README and manual: blocks marked ``sh`` or ``python`` are run at a coarse size, others are checked.

A comment above each block says how it is run: see "This manual" in ``docs/developing.md``.
"""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from ncf_fenicsx import Scene

pytestmark = pytest.mark.serial
ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"(?:^<!-- *(?P<comment>[^\n]*?) *-->\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```", re.M | re.S)
COMMENT = re.compile(r"(?P<how>run|run slow|not run)(?:: *(?P<rest>.+))?")
INLINE = re.compile(r"`docker/run ([^`]+)`")
RUN = ("sh", "python")
"""Languages of blocks that are run."""
LONGEST = 600
"""Seconds that a command may take."""


@dataclass(frozen=True)
class Block:
    """A block of commands with the comment above it."""

    place: str
    language: str
    comment: str
    text: str

    @property
    def mark(self):
        """What the comment says, and its arguments or reason."""
        found = COMMENT.fullmatch(self.comment)
        return (found["how"], found["rest"] or "") if found else ("", "")

    @property
    def commands(self):
        """Words of each command as they stand there, without comments; a script is one command."""
        if self.language == "python":
            return [["docker/run", "python3", "-c", self.text]]
        lines = self.text.replace("\\\n", " ").splitlines()
        return [words for words in (shlex.split(line, comments=True) for line in lines) if words]

    @property
    def coarse(self):
        """Words of each command with the arguments of the comment, where it names a scene or a script."""
        extra = shlex.split(self.mark[1])
        return tuple((*words, *(extra if takes_arguments(words) else ())) for words in self.commands)


def takes_arguments(words):
    """Whether a command names a scene or a script, or measures the laws."""
    return "benchmark" in words or any(word.endswith((".toml", ".py")) for word in words)


def blocks(*languages):
    for page in PAGES:
        text = page.read_text("utf-8")
        for found in BLOCK.finditer(text):
            if found["language"] in languages:
                line = text.count("\n", 0, found.start("text"))
                yield Block(f"{page.name}:{line}", found["language"], found["comment"] or "", found["text"])


def runs():
    """Each block to be run, unless all of its commands are run by blocks before it."""
    seen = set()
    for block in blocks(*RUN):
        how, _ = block.mark
        if how.startswith("run") and not set(block.coarse) <= seen:
            seen.update(block.coarse)
            yield pytest.param(block, id=block.place, marks=pytest.mark.slow if how == "run slow" else ())


@pytest.fixture
def checkout(tmp_path):
    """A folder that looks like the checkout, for results to be written into."""
    for path in ROOT.iterdir():
        if path.name not in ("results", "build") and not path.name.startswith("."):
            (tmp_path / path.name).symlink_to(path)
    return tmp_path


def started(words):
    """A command as it is started within the container."""
    here = {"ncf-fenicsx": [sys.executable, "-m", "ncf_fenicsx"], "python3": [sys.executable]}
    return [part for word in words[1:] for part in here.get(word, [word])]


@pytest.mark.parametrize("block", runs())
def test_commands_run(block, checkout):
    for words in block.coarse:
        assert words[0] == "docker/run", f"{block.place}: only commands of docker/run can be run"
        ended = subprocess.run(
            started(words),
            cwd=checkout,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
            timeout=LONGEST,
        )
        assert ended.returncode == 0, f"{shlex.join(words)}\n{ended.stdout[-2000:]}\n{ended.stderr[-2000:]}"


@pytest.mark.parametrize("block", blocks(*RUN), ids=lambda block: block.place)
def test_each_block_says_how_it_is_run(block):
    how, rest = block.mark
    assert how, f"{block.place}: expected <!-- run -->, <!-- run: ARGUMENTS --> or <!-- not run: REASON --> above"
    assert how != "not run" or rest, f"{block.place}: expected a reason"


@pytest.mark.parametrize("block", blocks("toml"), ids=lambda block: block.place)
def test_scenes_can_be_read(block):
    Scene.from_table(tomllib.loads(block.text))


def named():
    """Place and words of every command of `docker/run`, in blocks and within lines."""
    for block in blocks(*RUN):
        for words in block.commands:
            if words[0] == "docker/run":
                yield pytest.param(words[1:], id=f"{block.place} {words[1]}")
    for page in PAGES:
        for found in INLINE.finditer(BLOCK.sub("", page.read_text("utf-8"))):
            yield pytest.param(shlex.split(found[1]), id=f"{page.name} {found[1]}")


@pytest.mark.parametrize("words", named())
def test_files_and_keys_of_commands_exist(words):
    files = [word for word in words if word.startswith(("demos/", "meshes/", "tests/"))]
    for file in files:
        assert (ROOT / file).exists(), file
    scene = next((file for file in files if file.endswith(".toml")), None)
    if scene is not None:
        Scene.read(ROOT / scene, [words[i + 1] for i, word in enumerate(words) if word == "--set"])
    if words[0] == "pytest":
        for name in re.findall(r"\btest_\w+", " ".join(words)):
            assert list((ROOT / "tests").rglob(f"{name}.py")), name
