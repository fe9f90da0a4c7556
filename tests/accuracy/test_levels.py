"""Which scene a level is."""

import numpy as np
import pytest
from program import DEMOS, SMALL_STACK

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.accuracy.cost import Cost, duration, expected
from ncf_fenicsx.accuracy.levels import BELOW, Levels
from ncf_fenicsx.accuracy.quantities import check_quantities
from ncf_fenicsx.laws.contact import STIFFEST_LAYERS
from ncf_fenicsx.mesh.hexahedra import graded
from ncf_fenicsx.mesh.stack_mesh import focus_of
from ncf_fenicsx.simulation.stepping import pieces

pytestmark = pytest.mark.serial
NAMES = ["roller", "long_roller", "deep", "relaxation", "moving_roller", "convex_tool", "wrinkle"]


@pytest.mark.parametrize("name", NAMES)
def test_levels_are_nested_valid_and_about_the_scene_itself_after_two_halvings(name):
    scene = Scene.read(DEMOS / f"{name}.toml")
    levels = Levels(scene)
    focus, stack = focus_of(scene), scene.stack
    for level in range(4):
        coarse, fine = levels[level], levels[level + 1]
        Scene.from_table(coarse.table())
        for axis in (0, 1):
            lines = [
                graded(one.stack.divisions[axis], stack.size[axis], focus[axis], stack.grading[axis])
                for one in (coarse, fine)
            ]
            assert np.isin(lines[0].round(12), lines[1].round(12)).all()
        for one, two in zip(pieces(coarse), pieces(fine), strict=True):
            assert two.control.first == pytest.approx(one.control.first / 2)
            assert two.control.largest == pytest.approx(one.control.largest / 2)
        finer = 2 if scene.controls_time_error else 1
        assert coarse.solver.time_tolerance == pytest.approx(finer * fine.solver.time_tolerance)
    assert levels[BELOW].stack.divisions[0] == pytest.approx(stack.divisions[0], rel=0.26)
    assert levels[BELOW].solver.time_tolerance == pytest.approx(scene.solver.time_tolerance)
    assert levels[BELOW].stack.elements_through == stack.elements_through


def test_penalties_are_raised_up_to_where_they_let_nothing_through():
    scene = Scene.read(DEMOS / "roller.toml", ["interface.penalty='1e5 Pa/m'"])
    levels = Levels(scene)
    assert [levels[level].tool[0].penalty.value for level in range(5)] == [1e3, 4e3, 1.6e4, 1.6e4, 1.6e4]
    soft = [levels[level].interface[0].penalty.value for level in range(12)]
    assert soft[:3] == [1e5, 4e5, 1.6e6]
    assert soft[-1] == pytest.approx(STIFFEST_LAYERS * scene.natural_stiffness)
    stiff = Levels(Scene.read(DEMOS / "roller.toml", ["tool.penalty=1e6"]))
    assert stiff[3].tool[0].penalty.value == 1e6


def test_multipliers_and_sticks_are_refined_too():
    changes = ["tool.contact={kind='augmented_lagrangian'}", "interface.friction={coefficient=0.3}"]
    level = Levels(Scene.read(DEMOS / "roller.toml", changes))[1]
    assert level.tool[0].contact.tolerance == pytest.approx(1e-4 / 4)
    assert level.interface[0].friction.stiffness.value == 2


def test_one_element_is_enough_where_nothing_varies_and_two_where_that_is_seen():
    assert Levels(Scene.read(DEMOS / "deep.toml"))[3].stack.divisions[1] == 1
    long_roller = Scene.read(DEMOS / "long_roller.toml")
    assert [Levels(long_roller)[level].stack.divisions[1] for level in range(3)] == [2, 4, 8]
    assert [Levels(long_roller, flat=True)[level].stack.divisions[1] for level in range(3)] == [2, 2, 2]


def test_a_layer_s_elements_through_are_the_model_unless_they_are_to_be_resolved():
    asked = ["stack.through=resolved"]
    levels = Levels(Scene.read(DEMOS / "long_roller.toml", asked))
    assert [levels[level].stack.elements_through[0] for level in range(4)] == [1, 2, 4, 8]
    assert Scene.read(DEMOS / "long_roller.toml", asked).stack.elements_through == (4,) * 4
    with pytest.raises(SceneError, match="bending"):
        Scene.read(DEMOS / "relaxation.toml", asked)


def test_a_mesh_file_is_refused():
    table = {"stack": {"layers": 2, "mesh": str(SMALL_STACK)}, "duration": "1 s"}
    with pytest.raises(SceneError, match=r"stack\.mesh = .*: expected an extruded stack"):
        Levels(Scene.from_table(table))


def test_quantities_that_a_scene_has_not_are_named():
    check_quantities(Scene.read(DEMOS / "roller.toml"), ("force", "vf", "vf_field", "void_volume", "wrinkle_height"))
    bonded = Scene.read(DEMOS / "roller.toml", ["interface={kind='bonded'}"])
    with pytest.raises(
        SceneError, match=r"accuracy\.quantities = 'void_volume': expected .* force, vf, wrinkle_height"
    ):
        check_quantities(bonded, ("void_volume",))


def test_the_next_cost_goes_on_as_the_last_ones_did():
    scene = Levels(Scene.read(DEMOS / "deep.toml"))[3]
    before = [Cost(1000, 2.0, 2e8), Cost(2000, 6.0, 3e8)]
    found = expected(scene, before)
    assert found.seconds == pytest.approx(6.0 * (found.unknowns / 2000) ** np.log2(3))
    assert found.memory >= 3e8
    first = expected(scene, [])
    assert first.unknowns == found.unknowns
    assert 1 < first.seconds < 200


def test_times_are_told_as_people_do():
    assert [duration(seconds) for seconds in (0.31, 25, 110, 600, 8000)] == [
        "0.31 s",
        "25 s",
        "110 s",
        "10 min",
        "2.2 h",
    ]
