"""The path of a tool in time."""

import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.tools import path as motion

pytestmark = pytest.mark.serial


def path(*segments):
    return Scene.from_table({"tool": {"path": list(segments)}}).segments


PRESS = {"travel": ["0 mm", "0 mm", "-0.5 mm"], "speed": "1 mm/min"}
SLIDE = {"travel": ["3 mm", "4 mm", "0 mm"], "speed": "5 mm/s"}


def test_a_path_is_travelled_at_its_speeds():
    made = path(PRESS, {"hold": "10 s"}, SLIDE)
    assert motion.milestones(made) == pytest.approx([30, 40, 41])
    assert motion.displacement(made, 15) == pytest.approx((0, 0, -0.25e-3))
    assert motion.displacement(made, 35) == pytest.approx((0, 0, -0.5e-3))
    assert motion.displacement(made, 40.5) == pytest.approx((1.5e-3, 2e-3, -0.5e-3))
    assert motion.displacement(made, 99) == pytest.approx((3e-3, 4e-3, -0.5e-3))


def test_the_closing_speed_of_a_step_is_that_of_the_segment_it_ends():
    made = path(PRESS, {"hold": "10 s"}, SLIDE)
    assert motion.closing_speed(made, 30) == pytest.approx(1e-3 / 60)
    assert motion.closing_speed(made, 30.1) == 0
    assert motion.closing_speed(made, 40) == 0
    assert motion.closing_speed(made, 41) == 0  # it slides
