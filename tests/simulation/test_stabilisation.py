"""The rule of the viscosity alone: when it comes, grows and goes."""

import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.simulation.stabilisation import DEEP_TROUBLE, LOWER, PLAIN_TROUBLE, RAISE, TROUBLE, Steadying

pytestmark = pytest.mark.serial


def rule(stability_lost=True):
    return Steadying(first=1e7, first_step=1.0, stability_lost=stability_lost)


def test_a_step_cut_once_is_no_trouble():
    steadying = rule()
    steadying.failed(1.0)
    steadying.failed(TROUBLE * 1.01)
    assert steadying.value == 0


def test_troubles_without_a_loss_of_stability_get_it_later():
    steadying = rule(stability_lost=False)
    steadying.failed(0.9 * TROUBLE)
    steadying.failed(1.01 * PLAIN_TROUBLE)
    assert steadying.value == 0
    steadying.failed(0.99 * PLAIN_TROUBLE)
    assert steadying.value == 1e7


def test_it_comes_in_trouble_grows_in_deep_trouble_and_goes_where_steps_hold():
    steadying = rule()
    steadying.failed(0.9 * TROUBLE)
    steadying.failed(0.4 * TROUBLE)
    assert steadying.value == 1e7
    steadying.failed(0.9 * DEEP_TROUBLE)
    assert steadying.value == RAISE * 1e7
    steadying.held(0.9 * TROUBLE)
    assert steadying.value == RAISE * 1e7
    steadying.held(TROUBLE)
    assert steadying.value == pytest.approx(LOWER * RAISE * 1e7)
    for _ in range(50):
        steadying.held(TROUBLE)
    assert steadying.value == 0


def test_it_stays_away_where_the_scene_says_so(table):
    steadying = Steadying.of_scene(Scene.from_table(table | {"solver": {"steadying": "none"}}), 1.0)
    steadying.failed(1e-6)
    assert steadying.value == 0


@pytest.mark.parametrize("factor", [1, 10])
def test_its_force_is_a_share_of_the_layers_own_at_any_speed(table, factor):
    path = [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": f"{factor} mm/min"}]
    laws = {"rate": {"kind": "none"}}
    scene = Scene.from_table(table | {"laws": laws, "tool": table["tool"] | {"path": path}})
    first = Steadying.of_scene(scene, 1.0).first
    assert first * factor * 1e-3 / 60 == pytest.approx(5e-5 * scene.natural_stiffness, rel=1e-12)
