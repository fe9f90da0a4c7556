"""Shapes that cannot be followed: a step that ends in one does not hold, and leaves no trace."""

import re

import numpy as np
import pytest
from assembled import COMM, assign, build

from ncf_fenicsx.mechanics.time_step import Outcome, TimeStep
from ncf_fenicsx.output.face_waves import FaceWaves
from ncf_fenicsx.simulation.face_limits import FaceLimits
from ncf_fenicsx.simulation.progress_bar import ProgressBar

pytestmark = pytest.mark.two_ranks

LENGTH, THICKNESS = 60e-3, 0.5e-3


def strip(layers, divisions=60):
    table = {
        "duration": "1 s",
        "stack": {
            "layers": layers,
            "thickness": f"{THICKNESS} m",
            "areal_density": "356.25 g/m^2",
            "size": [f"{LENGTH} m", "2 mm"],
            "divisions": [divisions, 1],
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "y_min": "free"},
        },
        "laws": {"bending": {"modulus": "1 MPa"}},
        "mould": {"kind": "plate"},
    }
    problem, _ = build(table)
    progress = ProgressBar(1.0, COMM)
    return problem, FaceLimits(problem, FaceWaves(problem), progress), progress


def rolled_up(angle):
    """Displacement of a strip bent to an arc of an angle, its lower face as long as before."""

    def field(x):
        radius, turn = LENGTH / angle, angle * x[0] / LENGTH
        along, up = (radius - x[2]) * np.sin(turn), radius - (radius - x[2]) * np.cos(turn)
        return np.stack([along - x[0], 0 * x[1], up - x[2]])

    return field


@pytest.mark.parametrize(
    ("layers", "degrees", "words"),
    [
        (1, 80, None),
        (2, 80, None),
        (1, 120, None),
        (2, 120, r"upper face of layer 1 is turned by 1(19|20) degrees at \(.*\) mm: layers on each other"),
        (1, 340, None),
        (1, 420, r"upper face of layer 1 folds and touches itself at \(.*\) mm"),
    ],
)
def test_what_a_face_may_not_do_is_told_with_its_place(layers, degrees, words):
    problem, limits, _ = strip(layers)
    assign(problem, rolled_up(np.radians(degrees)))
    found = limits.violation()
    assert found is None if words is None else re.search(words, found)


def test_a_step_that_ends_in_such_a_shape_leaves_no_trace():
    problem, limits, _ = strip(2)
    before = problem.displacement.x.array.copy()

    def solve(time, size, effort):
        del time, size, effort
        assign(problem, rolled_up(np.radians(100)))
        return Outcome(True, 3, "converged")

    outcome = TimeStep(problem, solve, shape_violation=limits.violation).attempt(0.0, 0.5)
    assert not outcome.converged
    assert "layers on each other are followed in plan" in outcome.reason
    assert np.array_equal(problem.displacement.x.array, before)


@pytest.mark.parametrize(("divisions", "coarse"), [(12, False), (5, True)])
def test_a_curve_of_few_elements_is_told_once_with_the_length_that_it_asks_for(divisions, coarse):
    problem, limits, progress = strip(1, divisions)
    assign(problem, rolled_up(np.pi))
    for time in (1.0, 2.0):
        limits.watch(time)
    assert len(progress.cautions) == coarse
    if coarse:
        assert "turns by 36 degrees" in progress.cautions[0]
        assert "at 1 s: " in progress.cautions[0]
