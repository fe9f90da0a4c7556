"""Pages of runs that are not the usual one: each opens quietly, and says what there is."""

import re

import pytest
from program import call

from ncf_fenicsx import Scene, run

pytestmark = pytest.mark.serial
PAGE = "report.html"
QUIET = {"picture": False}
STACK = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [4, 2], "grading": [0.0, 0.0]}
STITCHED = {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0}
DOWN = [{"travel": ["0 mm", "0 mm", "-0.1 mm"], "speed": "1 mm/min"}]
ROLLER = {"width": "infinite", "path": DOWN}
BALL = {"kind": "sphere", "radius": "2 mm", "position": ["8 mm", "0 mm"], "path": DOWN}


def case(**tables):
    return {"stack": STACK, "interface": STITCHED, "tool": ROLLER, "output": QUIET} | tables


CASES = {
    "stopped early": (case(solver={"max_steps": 2}), "Stopped early at .*: max_steps"),
    "a single element": (
        case(
            stack={"layers": 1, "size": ["10 mm", "10 mm"], "divisions": [1, 1]}, tool={"kind": "plate", "path": DOWN}
        ),
        "One layer .*pressed by a plate, which moves 0.1 mm down",
    ),
    "a solid": (case(laws={"solid": {"kind": "logarithmic"}}), "2 layers of a solid .*Largest contact pressure"),
    "no tool": (
        {"stack": STACK, "interface": STITCHED, "output": QUIET, "duration": "2 s"},
        "2 layers .*, at rest for 2 s",
    ),
    "several tools": (case(tool=[ROLLER, BALL]), "pressed by 2 tools: a cylinder .*; a sphere .*tool 2"),
    "on a mould": (
        case(
            mould={"kind": "cylinder", "radius": "50 mm"},
            tool={"kind": "presser_foot", "size": ["8 mm", "8 mm"], "path": DOWN},
        ),
        "on a cylinder mould by a presser foot",
    ),
    "order 2": (case(stack=STACK | {"order": 2}), "Done at 6 s of 6 s"),
}


@pytest.mark.parametrize("name", CASES)
def test_page_is_right(browser, tmp_path, name):
    table, words = CASES[name]
    run(Scene.from_table(table), tmp_path / "run")
    browser.open(tmp_path / "run" / PAGE)
    text = browser.run("return document.querySelector('main').textContent")
    assert re.search(words, text, re.DOTALL), text[:900]
    assert browser.complaints() == []
    assert browser.run("return document.getElementById('view').hidden") is False
    assert browser.run("return document.querySelectorAll('figure').length") > 3
    ends = [float(browser.text(f"#{name}").split()[0]) for name in ("low", "high")]
    assert ends[0] <= ends[1]
    assert browser.overflow() <= 0


def test_two_ranks_write_the_page_of_one(browser, tmp_path):
    """Numbers of nodes and rows do not depend on the ranks; what is shown does not either."""
    file = tmp_path / "scene.toml"
    file.write_text(SCENE, encoding="utf-8")
    shown = []
    for ranks in (1, 2):
        out = tmp_path / f"ranks_{ranks}"
        done = call("run", file, "--out", out, ranks=ranks)
        assert done.returncode == 0, done.stderr
        browser.open(out / PAGE)
        assert browser.complaints() == []
        shown.append([browser.text(f"#{name}") for name in ("low", "high", "summary")])
    assert shown[0] == shown[1]


SCENE = """
[stack]
layers = 2
size = ["12 mm", "6 mm"]
divisions = [4, 2]
grading = [0.0, 0.0]
[interface]
kind = "stitched"
yarn_stiffness = "0.01 N"
slip_share = 0.0
[tool]
width = "infinite"
[[tool.path]]
travel = ["0 mm", "0 mm", "-0.1 mm"]
speed = "1 mm/min"
[output]
picture = false
"""
