"""Where tools start and go: what is impossible is one line, what is doubtful a caution, both with what would do."""

import math
import re

import numpy as np
import pytest
from assembled import COMM, build

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mesh import build_mesh


def cautions(table):
    return build_mesh(Scene.from_table(table), COMM).cautions


def test_the_fixture_raises_no_caution(table):
    assert cautions(table | {"tool": table["tool"] | {"radius": "6 mm"}}) == []


@pytest.mark.parametrize("kind", ["cylinder", "sphere"])
def test_a_concave_mould_that_cuts_into_the_stack_is_told_how_far_to_go_down(table, kind, folder):
    """The corner of 12 x 6 mm lies above a circle of 50 mm: R - sqrt(R^2 - r^2) is the clearance that would do."""
    table["mould"] = {"kind": kind, "shape": "concave", "radius": "50 mm"}
    reach = math.hypot(12, 6) if kind == "sphere" else 12
    needed = 50 - math.sqrt(50**2 - reach**2)
    with pytest.raises(SceneError, match=r"mould.clearance = 0 mm: it starts .* inside the stack") as caught:
        run(Scene.from_table(table), folder / "none")
    offered = float(re.search(r"at least ([\d.]+) mm", str(caught.value))[1])
    assert offered == pytest.approx(needed, abs=5e-3)
    assert COMM.rank or not (folder / "none").exists()
    table["mould"]["clearance"] = f"{offered} mm"
    build(table)[0].contacts.check_start()


def test_a_tool_beside_its_tip_that_cuts_into_the_stack_is_found(table):
    """A profile whose lowest point is not at its position."""
    table["tool"] = {"kind": "profile", "points": [["-4 mm", "1 mm"], ["0 mm", "1 mm"], ["4 mm", "0 mm"]]}
    problem, _ = build(table)
    problem.contacts.check_start()
    problem.contacts.tools[0].tip.value[2] -= 3e-4
    assert problem.contacts.tools[0].depth_at_start() == pytest.approx(3e-4, rel=0.5)


def test_a_path_off_the_stack_is_named_with_its_time_and_the_limits(table):
    table["tool"]["path"] = [{"hold": "2 s"}, {"travel": ["20 mm", "0 mm", "0 mm"], "speed": "10 mm/s"}]
    assert "tool.path: at 4 s the tip is at x = 20 mm, off the stack; expected 0 to 12 mm" in cautions(table)


def test_elements_too_long_for_a_radius_are_named_with_what_would_do(table):
    table["tool"] |= {"radius": "3 mm"}
    (words,) = cautions(table)
    assert "up to 2 mm long along x; expected at most 1 mm, a third of its radius: 2 times as many" in words
    table["stack"]["divisions"] = [12, 2]
    assert cautions(table) == []


def test_only_elements_where_the_tool_comes_count(table):
    table["stack"] |= {"divisions": [24, 2], "grading": [0.9, 0.0], "size": ["24 mm", "6 mm"]}
    assert cautions(table) == []
    table["tool"]["path"] = [{"travel": ["20 mm", "0 mm", "0 mm"], "speed": "10 mm/s"}]
    assert np.any(["along x" in words for words in cautions(table)])


def test_several_tools_are_told_apart(table):
    first = {"kind": "plate", "path": [{"hold": "1 s"}]}
    second = {"kind": "sphere", "radius": "1 mm", "position": ["50 mm", "0 mm"], "path": [{"hold": "1 s"}]}
    words = cautions(table | {"tool": [first, second]})
    assert any(word.startswith("tool_2.path") for word in words)
    assert not any(word.startswith("tool.") for word in words)


def test_elements_longer_than_the_tool_are_named_although_their_centres_are_out_of_its_reach(table):
    table["stack"] |= {"divisions": [2, 2], "size": ["60 mm", "6 mm"]}
    words = cautions(table)
    assert len(words) == 1
    assert "up to 30 mm long along x; expected at most 0.833 mm" in words[0]
