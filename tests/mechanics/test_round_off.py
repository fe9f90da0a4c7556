"""The forces that round-off leaves are not above the floor that they are held against."""

from program import DEMOS

from ncf_fenicsx import Scene, simulation

STRIP = [
    "stack.layers=2",
    "stack.divisions=[960, 1]",
    "laws.shear.modulus=2 MPa",
    "tool.penalty=1e11 Pa/m",
    "interface.penalty=1e10 Pa/m",
    'tool.path.0.travel=["0 mm", "0 mm", "-0.03 mm"]',
    "output.report=false",
    "output.picture=false",
]
"""Elements some 0.03 mm long, 2 mm high and 15 mm wide: fibres pull at upright faces 64 times those in the plane."""
ITERATIONS = 9
"""Of a step at most: one that waits for less than round-off takes all it may have, and the run stops."""


def test_elements_far_shorter_than_high_come_to_rest(tmp_path):
    ended = simulation.run(Scene.read(DEMOS / "long_roller.toml", STRIP), tmp_path / "results")
    assert ended.done, ended.reason
    assert not sum(row["step_cuts"] for row in ended.history)
    assert max(row["newton_iterations"] for row in ended.history) <= ITERATIONS
