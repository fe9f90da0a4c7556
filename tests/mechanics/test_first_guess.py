"""The first guess of a step: motion goes on, and where a tool turns only for a moment, with friction."""

import numpy as np
import pytest
from assembled import build, step_of

from ncf_fenicsx.mechanics.time_step import MOMENT

pytestmark = pytest.mark.two_ranks

TURNS = [
    {"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"},
    {"travel": ["1 mm", "0 mm", "0 mm"], "speed": "20 mm/min"},
]
CORNER, SPEED = 12.0, 1e-5


@pytest.mark.parametrize(("friction", "held"), [(True, False), (False, False), (True, True)])
def test_motion_goes_on_in_the_guess_and_round_a_corner_for_a_moment(table, friction, held):
    hold = [{"force": "1 N", "hold": "5 s"}] if held else []
    tool = table["tool"] | {"path": TURNS + hold} | ({"friction": {"coefficient": 0.2}} if friction else {})
    problem, _ = build(table | {"tool": tool})
    step = step_of(problem)
    step.commit()
    step._velocity.commit(np.full_like(problem.displacement.x.array, SPEED))
    moment = MOMENT * problem.scene.stack.thickness / SPEED

    def guessed(time, size):
        step.begin(time, size)
        moved = problem.displacement.x.array - problem.start.x.array
        step.rollback(time)
        return moved

    around = SPEED if friction and not held else 0.0
    assert guessed(0.0, 1.0) == pytest.approx(SPEED)
    assert guessed(0.0, CORNER) == pytest.approx(CORNER * SPEED)
    assert guessed(CORNER, 0.9 * moment) == pytest.approx(0.9 * moment * around)
    assert guessed(CORNER, 1.1 * moment) == pytest.approx(0.0)
