"""The first guess of a step: motion goes on; where a tool turns for a moment only, with friction or after a failure."""

import numpy as np
import pytest
from assembled import build, step_of
from program import DEMOS

from ncf_fenicsx import Scene, simulation
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

    assert guessed(0.0, 1.0) == pytest.approx(SPEED)
    assert guessed(0.0, CORNER) == pytest.approx(CORNER * SPEED)
    for failed in (False, True):
        step._failed = failed
        around = SPEED if (friction or failed) and not held else 0.0
        assert guessed(CORNER, 0.9 * moment) == pytest.approx(0.9 * moment * around)
        assert guessed(CORNER, 1.1 * moment) == pytest.approx(0.0)


ROLLS_ON = [
    "stack.layers=2",
    'stack.size=["16 mm", "0.5 mm"]',
    "stack.divisions=[32, 1]",
    'tool.position=["7 mm", "0 mm"]',
    "tool.penalty=16000.0",
    "interface.penalty=160.0",
    'tool.path.0.travel=["0 mm", "0 mm", "-0.3 mm"]',
    'tool.path.1.travel=["0.05 mm", "0 mm", "0 mm"]',
    'tool.path.2.travel=["0 mm", "0 mm", "0.01 mm"]',
    "solver.first_step=0.02 s",
    "output.report=false",
    "output.picture=false",
]
"""Short steps, and stiff contact: from a guess at rest each step after the first turn fails, down to 2 us."""
PRESSED, MOST_CUTS = 18.0, 4
"""Time in s of the first turn, and steps that may fail from there on: two do."""


def test_a_pressing_roller_rolls_on_however_short_the_step(tmp_path):
    ended = simulation.run(Scene.read(DEMOS / "moving_roller.toml", ROLLS_ON), tmp_path / "results")
    assert ended.done, ended.reason
    assert sum(row["step_cuts"] for row in ended.history if row["time"] > PRESSED) <= MOST_CUTS
