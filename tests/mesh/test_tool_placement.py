"""Where tools start and go: what is impossible is one line, what is doubtful a caution, both with what would do."""

import json
import math
import re

import numpy as np
import pytest
from assembled import COMM, build
from gmsh_files import stack, text_22
from program import call

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.simulation.preview import preview

pytestmark = pytest.mark.two_ranks


def about_tools(words):
    """Without cautions of laws, which the fixture's defaults have."""
    return [caution for caution in words if not caution.startswith("laws.")]


def cautions(table):
    return about_tools(build_mesh(Scene.from_table(table), COMM).cautions)


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
    second = {"kind": "sphere", "radius": "1 mm", "position": ["12.5 mm", "0 mm"], "path": [{"hold": "1 s"}]}
    words = cautions(table | {"tool": [first, second]})
    assert any(word.startswith("tool_2.path") for word in words)
    assert not any(word.startswith("tool.") for word in words)


def test_elements_longer_than_the_tool_are_named_although_their_centres_are_out_of_its_reach(table):
    table["stack"] |= {"divisions": [2, 2], "size": ["60 mm", "6 mm"]}
    words = cautions(table)
    assert len(words) == 1
    assert "up to 30 mm long along x; expected at most 0.833 mm" in words[0]


@pytest.mark.parametrize(
    ("tool", "expected"),
    [
        (
            {"kind": "sphere", "radius": "1 mm", "position": ["50 mm", "0 mm"]},
            "tool.position: on its path the tool is over x = 49 to 51 mm, the stack lies at x = 0 to 12 mm: "
            "they never meet; expected a tool over the stack",
        ),
        ({"kind": "cylinder", "position": ["-3 mm", "0 mm"]}, "over x = -5.5 to -0.5 mm"),
        (
            {"kind": "cylinder", "width": "4 mm", "position": ["0 mm", "9 mm"]},
            "over y = 7 to 11 mm, the stack lies at y = 0",
        ),
        ({"kind": "presser_foot", "position": ["0 mm", "-11 mm"]}, "over y = -21 to -1 mm"),
        ({"kind": "profile", "position": ["24 mm", "0 mm"]}, "over x = 13.5 to 34.5 mm"),
    ],
)
def test_a_tool_beside_the_stack_on_all_of_its_path_is_impossible(tool, expected, table):
    with pytest.raises(SceneError, match=re.escape(expected)):
        cautions(table | {"tool": tool})


def test_a_path_through_the_plane_under_the_stack_is_impossible_and_one_above_it_or_beside_the_stack_is_not(table):
    """Contact by penalty would let the tool through, and the run would end as if nothing was wrong."""
    stack = Scene.from_table(table).stack
    height = 1e3 * stack.layers * stack.thickness

    def down(depth, **more):
        steps = [{"travel": ["0 mm", "0 mm", f"-{depth} mm"], "speed": "1 mm/min"}]
        return table | {"tool": table["tool"] | {"path": steps} | more}

    said = "tool.path: its lowest tip is at z = -1 mm, the rigid plane under the stack at 0 mm; expected a path"
    with pytest.raises(SceneError, match=re.escape(said)):
        cautions(down(height + 1))
    with pytest.raises(SceneError, match="its lowest tip is at z = 0 mm"):
        cautions(down(height))
    cautions(down(height - 0.1))
    cautions(down(height + 1, position=["-2 mm", "0 mm"]))
    cautions(down(height + 1) | {"mould": {"kind": "cylinder", "shape": "convex", "radius": "200 mm"}})


@pytest.mark.parametrize(
    "tool",
    [
        {"kind": "cylinder", "position": ["-2 mm", "0 mm"]},
        {
            "kind": "cylinder",
            "position": ["-9 mm", "0 mm"],
            "path": [{"travel": ["8 mm", "0 mm", "0 mm"], "speed": "1 mm/s"}],
        },
        {"kind": "cylinder", "width": "infinite", "position": ["0 mm", "90 mm"]},
        {"kind": "plate", "position": ["90 mm", "90 mm"]},
    ],
)
def test_a_tool_that_may_meet_the_stack_is_not(tool, table):
    assert not any("never meet" in words for words in cautions(table | {"tool": tool}))


def test_a_path_that_stays_above_the_stack_is_named_with_both_heights(table):
    down = {"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}
    table["tool"] |= {"radius": "6 mm", "clearance": "0.5 mm", "path": [down]}
    (words,) = cautions(table)
    assert "tool.path: its lowest tip is at z = 4.3 mm, the top of the stack at 4 mm: they never meet" in words
    table["tool"]["path"] = [down, down, down]
    assert cautions(table) == []
    table["tool"]["path"] = [{"hold": "1 s", "force": "1 N"}]
    assert cautions(table) == []


@pytest.mark.parametrize(
    ("tool", "sides", "expected"),
    [
        ({}, {}, None),
        (
            {"position": ["4 mm", "0 mm"]},
            {},
            "beside the plane of symmetry x_min, so its images press too: tool_force is that of 2",
        ),
        ({"position": ["4 mm", "0 mm"]}, {"x_min": "fixed"}, None),
        (
            {"position": ["4 mm", "3 mm"]},
            {},
            "beside the plane of symmetry x_min, so its images press too: tool_force is that of 2",
        ),
        ({"position": ["4 mm", "3 mm"], "width": "2 mm"}, {}, "beside the planes of symmetry x_min and y_min, so"),
        ({"position": ["4 mm", "3 mm"], "width": "2 mm"}, {"y_max": "symmetry"}, "tool_force is that of 8 tools"),
        ({}, {"x_max": "symmetry"}, "beside the plane of symmetry x_max"),
        ({"path": [{"travel": ["5 mm", "0 mm", "0 mm"], "speed": "1 mm/s"}]}, {}, "beside the plane of symmetry x_min"),
        ({"kind": "plate", "position": ["4 mm", "3 mm"]}, {}, None),
    ],
)
def test_a_tool_beside_a_plane_of_symmetry_is_there_more_than_once(tool, sides, expected, table):
    table["stack"]["sides"] = sides
    roller = {"kind": "cylinder", "radius": "6 mm", "width": "infinite"}
    found = [
        words
        for words in cautions(table | {"tool": roller | tool if "kind" not in tool else tool})
        if "symmetry" in words
    ]
    assert len(found) == (expected is not None)
    assert not found or expected in found[0]


MESHES = [
    ({}, (20, -30)),
    ({"x_max": "symmetry", "x_min": "free"}, (32, -30)),
    ({"x_min": "fixed", "y_min": "free"}, (26, -27)),
    ({"y_min": "free", "y_max": "symmetry"}, (20, -24)),
]


def far_away(folder):
    """A mesh file whose stack begins at (20, -30, 5) mm."""
    if COMM.rank == 0:
        mesh = stack().with_points(lambda points: points + np.array([20e-3, -30e-3, 5e-3]))
        (folder / "far.msh").write_text(text_22(mesh), encoding="utf-8")
    COMM.barrier()
    return {"layers": 2, "mesh": str(folder / "far.msh")}


@pytest.mark.parametrize(("sides", "place"), MESHES)
def test_a_tool_without_a_place_is_over_the_corner_or_middle_of_a_mesh_file(sides, place, table, folder):
    table["tool"] = [table["tool"], {"kind": "plate", "position": ["21 mm", "0 mm"]}]
    scene = Scene.from_table(table | {"stack": far_away(folder) | {"sides": sides}, "mould": {"kind": "plate"}})
    problem = Problem(scene, build_mesh(scene, COMM))
    assert problem.contacts.tools[0].tip.value[:2] == pytest.approx(np.array(place) * 1e-3)
    assert problem.contacts.tools[1].tip.value[:2] == pytest.approx([21e-3, 0.0])
    assert problem.contacts.mould.tip.value[:2] == pytest.approx(np.array(place) * 1e-3)
    assert "position" not in scene.table()["mould"]
    assert ["position" in tool for tool in scene.table()["tool"]] == [False, True]
    assert Scene.from_table(problem.scene.table()).tool[0].position == pytest.approx(np.array(place) * 1e-3)


def test_a_mesh_file_anywhere_gives_the_history_of_one_at_the_origin(table, folder):
    origin = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [3, 2], "grading": [0.0, 0.0]}
    near = run(Scene.from_table(table | {"stack": origin}), folder / "near").history
    far = run(Scene.from_table(table | {"stack": far_away(folder)}), folder / "far").history
    assert near[-1]["tool_force"] > 0
    assert [row["tool_force"] for row in far] == pytest.approx([row["tool_force"] for row in near], rel=1e-6, abs=1e-12)
    written = Scene.read(folder / "far" / "scene.toml")
    assert written.tool[0].position == pytest.approx((20e-3, -30e-3))


def test_a_run_whose_tool_never_touches_says_so(table, folder):
    table["tool"] |= {"radius": "6 mm", "clearance": "0.5 mm"}
    result = run(Scene.from_table(table), folder / "out")
    assert result.done
    kept = COMM.bcast(json.loads((folder / "out" / "run.json").read_text("utf-8")) if COMM.rank == 0 else None)[
        "cautions"
    ]
    assert any("never meet unless the stack rises" in words for words in kept)
    (last,) = [words for words in kept if "never touched" in words]
    assert re.match(r"tool never touched the stack: tool_force is 0, and 0\.3\d* mm are left", last)
    del table["tool"]["clearance"]
    run(Scene.from_table(table), folder / "touches")
    COMM.barrier()
    assert about_tools(json.loads((folder / "touches" / "run.json").read_text("utf-8"))["cautions"]) == []


@pytest.mark.serial
def test_check_and_run_say_that_a_tool_never_meets_the_stack_and_write_nothing(folder):
    text = '[stack]\ndivisions = [4, 4]\n[tool]\nposition = ["200 mm", "0 mm"]\n'
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    for words in (["check", "scene.toml"], ["run", "scene.toml", "--out", "out"]):
        ended = call(*words, folder=folder)
        assert ended.returncode == 2
        (line,) = ended.stderr.splitlines()
        assert "x = 197.5 to 202.5 mm, the stack lies at x = 0 to 76 mm: they never meet" in line
    assert not (folder / "out").exists()


def test_check_says_where_a_mesh_file_puts_the_tool(table, folder):
    scene = Scene.from_table(table | {"stack": far_away(folder)})
    assert "\ntool.position: (20, -30) mm, by the mesh\n" in preview(scene)
