"""What a restart may change in a scene: a list; all else is one line with the key and both values."""

import copy

import pytest

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.scene.changes import check_changes
from ncf_fenicsx.scene.scene_file import apply_override

pytestmark = pytest.mark.serial

DOWN = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}  # 18 s
HOLD = {"hold": "10 s", "force": "2 N"}
UP = {"travel": ["0 mm", "0 mm", "0.3 mm"], "speed": "2 mm/min"}
TABLE = {
    "stack": {"layers": 2},
    "interface": {"kind": "stitched"},
    "tool": {"path": [DOWN, HOLD, dict(HOLD), UP]},
    "laws": {"rate": {"feed": "process"}},
}
DOWN_AGAIN = "{travel=['0 mm', '0 mm', '-0.3 mm'], speed='1 mm/min'}"
DOWN_FURTHER = "{travel=['0 mm', '0 mm', '-0.4 mm'], speed='1 mm/min'}"

ALLOWED = {
    "nothing": (10, []),
    "title": (10, ["title=another"]),
    "solver": (10, ["solver.max_steps=3", "solver.first_step=0.1 s", "solver.factors=new"]),
    "output": (10, ["output.fields_every=3", "output.permeability={}"]),
    "longer, on its way": (10, ["tool.path.0=" + DOWN_FURTHER]),
    "shorter, on its way": (10, ["tool.path.0.travel=['0 mm', '0 mm', '-0.2 mm']"]),
    "what is to come": (10, ["tool.path.1={hold='3 s'}", "tool.path.3={hold='9 s', force='1 N'}"]),
    "longer, at its end": (18, ["tool.path.0=" + DOWN_FURTHER]),
    "a force kept longer": (30, ["tool.path.2.hold=1 h"]),
    "the rest": (37, ["tool.path.3.travel=['0 mm', '0 mm', '1 mm']"]),
}  # fmt: skip

REFUSED = {
    "divisions": (10, ["stack.divisions=[5, 2]"], "stack.divisions = [5, 2]: a restart may change"),
    "thickness": (10, ["stack.thickness=3 mm"], "stack.thickness = '0.003 m'"),
    "a side": (10, ["stack.sides.x_max=fixed"], "stack.sides.x_max = 'fixed'"),
    "a law's parameter": (10, ["laws.compaction.beta2=20"], "laws.compaction.beta2 = 20.0"),
    "a law more": (10, ["laws.bending={}"], "laws.bending = another table"),
    "kind of a tool": (10, ["tool={kind='plate', path=[{hold='50 s', force='1 N'}]}"], "tool.kind = 'plate'"),
    "a tool's radius": (10, ["tool.radius=3 mm"], "tool.radius = '0.003 m'"),
    "gravity": (10, ["gravity=0 m/s^2"], "gravity = '0.0 m/s^2'"),
    "an interface": (10, ["interface.kind=one_sided"], "interface.kind = 'one_sided'"),
    "speed on its way": (10, ["tool.path.0.speed=0.5 mm/min"], "tool.path.0: has been travelled for 10 s"),
    "way on its way": (10, ["tool.path.0.travel=['0.1 mm', '0 mm', '-0.3 mm']"], "tool.path.0: has been travelled for"),
    "shorter than it is": (10, ["tool.path.0.travel=['0 mm', '0 mm', '-0.1 mm']"], "tool.path.0: has been travelled"),
    "a piece that is past": (20, ["tool.path.0=" + DOWN_FURTHER], "tool.path.0: has been travelled; expected"),
    "a ramp that it is in": (20, ["tool.path.1.hold=20 s"], "tool.path.1: has been travelled for 2 s"),
    "a force that it is in": (20, ["tool.path.1.force=3 N"], "tool.path.1: has been travelled for 2 s"),
    "an end before": (30, [f"tool.path=[{DOWN_AGAIN}, {{hold='10 s', force='2 N'}}]"],
                      "tool.path ends at 28 s; expected an end at 30 s"),
    "faster than all before": (10, ["tool.path.3={travel=['0 mm', '0 mm', '-0.1 mm'], speed='9 mm/min'}"],
                               "expected 1 mm/min to stay the highest speed downwards"),
    "no force": (10, ["tool.path=[" + DOWN_FURTHER + "]"], "expected forces only if"),
}  # fmt: skip


def changed(overrides):
    table = copy.deepcopy(TABLE)
    for text in overrides:
        apply_override(table, text)
    return Scene.from_table(table)


@pytest.mark.parametrize("case", ALLOWED)
def test_how_it_is_solved_and_written_and_what_is_to_come_may_change(case):
    time, overrides = ALLOWED[case]
    new = changed(overrides)
    assert bool(overrides) == (new != Scene.from_table(TABLE))
    check_changes(Scene.from_table(TABLE), new, time, "run")


@pytest.mark.parametrize("case", REFUSED)
def test_what_the_state_is_made_of_may_not(case):
    time, overrides, expected = REFUSED[case]
    with pytest.raises(SceneError) as caught:
        check_changes(Scene.from_table(TABLE), changed(overrides), time, "run")
    assert str(caught.value).startswith("run: ")
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_duration_may_grow_but_not_end_before():
    old, new = (Scene.from_table({"duration": f"{duration} s"}) for duration in (20, 15))
    check_changes(old, new, 10.0, "run")
    with pytest.raises(SceneError, match="duration ends at 15 s; expected an end at 18 s, where it is, or later"):
        check_changes(old, new, 18.0, "run")


def test_a_tool_among_several_is_named():
    tools = [{"kind": "plate", "path": [{"hold": "5 s"}]}, {"kind": "sphere", "path": [{"hold": "5 s"}]}]
    other = [tools[0], tools[1] | {"radius": "3 mm"}]
    with pytest.raises(SceneError, match=r"run: tool\.1\.radius = '0.003 m'.*expected '0.005 m'"):
        check_changes(Scene.from_table({"tool": tools}), Scene.from_table({"tool": other}), 1.0, "run")
