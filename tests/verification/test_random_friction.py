"""Random scenes with friction everywhere: there and back, over wide ranges; nearly all end, the others say why."""

import numpy as np
import pytest
from random_scenes import check

pytestmark = pytest.mark.serial

ENFORCEMENTS = [{}, {"contact": {"kind": "augmented_lagrangian"}}, {"contact": {"kind": "nitsche"}}]
MOULDS = [
    {"kind": "plate"},
    {"kind": "cylinder", "radius": "100 mm", "shape": "convex"},
    {"kind": "cylinder", "radius": "100 mm", "shape": "concave", "clearance": "3 mm"},
    {"kind": "sphere", "radius": "150 mm"},
]
TOOLS = [
    {"kind": "cylinder", "width": "infinite", "radius": "4 mm"},
    {"kind": "presser_foot", "size": ["6 mm", "6 mm"], "edge": "2 mm"},
    {"kind": "sphere", "radius": "6 mm"},
]
SCENES, LEAST_ENDED = 100, 0.95


def table(seed):
    """A tool presses, travels and comes back; coefficients, sticks, enforcements, moulds and layers are drawn.

    Each scene has numbers of its own: hypothesis draws many that differ in one number.
    """
    rng = np.random.default_rng(seed)

    def decades(low, high):
        return float(10 ** rng.uniform(np.log10(low), np.log10(high)))

    def choice(ways):
        return dict(ways[rng.integers(len(ways))])

    def touches():
        friction = {"coefficient": decades(0.05, 2.0), "stiffness": decades(0.01, 100)}
        return choice(ENFORCEMENTS) | {"friction": friction}

    thickness, layers = rng.uniform(0.4, 2.0), int(rng.integers(1, 5))
    depth, along, speed = layers * thickness * rng.uniform(0.03, 0.2), rng.uniform(0.2, 3.0), decades(0.1, 100)
    ways = [(0.0, -depth, 1.0), (along, 0.0, speed), (-along, 0.0, speed)]
    return {
        "stack": {
            "layers": layers,
            "thickness": f"{thickness} mm",
            "areal_density": f"{0.4 * thickness * 1790} g/m^2",
            "size": ["24 mm", "8 mm"],
            "divisions": [[24, 1], [16, 3], [12, 2]][rng.integers(3)],
            "grading": [0, 0],
            "sides": {"x_min": ["free", "fixed"][rng.integers(2)], "x_max": "fixed", "y_max": "symmetry"},
        },
        "laws": {
            "bending": {"modulus": f"{decades(1e7, 1e9)} Pa"},
            "shear": {"modulus": f"{decades(3e5, 1e7)} Pa"},
        },
        "interface": {"kind": "one_sided"} | touches(),
        "mould": choice(MOULDS) | touches(),
        "tool": choice(TOOLS)
        | {
            "position": ["8 mm", "0 mm"],
            "path": [{"travel": [f"{x} mm", "0 mm", f"{z} mm"], "speed": f"{v} mm/min"} for x, z, v in ways],
        }
        | touches(),
        "solver": {"max_steps": 1000},
        "output": {"picture": False, "report": False, "fields_every": 1000},
    }


@pytest.mark.parametrize("seed", [0, 42])
def test_a_few_scenes_with_friction_end(seed):
    assert check(table(seed))


@pytest.mark.slow
def test_nearly_all_of_a_hundred_scenes_with_friction_end():
    ended = [check(table(seed)) for seed in range(SCENES)]
    assert sum(ended) >= LEAST_ENDED * SCENES
