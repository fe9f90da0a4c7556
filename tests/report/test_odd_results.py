"""Pages of runs that are not the usual one: each opens quietly, and says what there is."""

import re

import pytest
import tomli_w
from program import call
from scenes_of_pages import BALL, FOOT, ROLLER, STACK, STITCHED, case, down

from ncf_fenicsx import Scene, run

pytestmark = pytest.mark.serial
PAGE = "report.html"
CASES = {
    "stopped early": (case(solver={"max_steps": 2}), "Stopped early at .*: max_steps"),
    "a single element": (
        case(
            stack={"layers": 1, "size": ["10 mm", "10 mm"], "divisions": [1, 1]},
            tool={"kind": "plate", "path": down("0.1 mm")},
        ),
        "One layer .*pressed by a plate, which moves 0.1 mm down",
    ),
    "a solid": (case(laws={"solid": {"kind": "logarithmic"}}), "2 layers of a solid .*Largest contact pressure"),
    "no tool": (
        {"stack": STACK, "interface": STITCHED, "output": {"picture": False}, "duration": "2 s"},
        "2 layers .*, at rest for 2 s",
    ),
    "several tools": (case(tool=[ROLLER, BALL]), "pressed by 2 tools: a cylinder .*; a sphere .*tool 2"),
    "on a mould": (
        case(mould={"kind": "cylinder", "radius": "50 mm"}, tool=FOOT),
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
    file.write_text(tomli_w.dumps(case()), encoding="utf-8")
    shown = []
    for ranks in (1, 2):
        out = tmp_path / f"ranks_{ranks}"
        done = call("run", file, "--out", out, ranks=ranks)
        assert done.returncode == 0, done.stderr
        browser.open(out / PAGE)
        assert browser.complaints() == []
        shown.append([browser.text(f"#{name}") for name in ("low", "high", "summary")])
    assert shown[0] == shown[1]
