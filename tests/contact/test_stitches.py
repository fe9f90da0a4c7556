"""Stitches pull in proportion to gap and slip, and remember a slip over elements."""

import numpy as np
import pytest
from assembled import COMM, build, step_of
from layers import PARTS, STITCH, move, two_layers, upper_nodes

OPENING = 8.0 / (2e-3 * 4e-3 * 10e-3)
"""EA / (length pitch pitch) in Pa/m."""


@pytest.mark.parametrize("divisions", PARTS.values(), ids=PARTS)
def test_stitches_pull_in_proportion_to_gap_and_slip(divisions):
    problem, _ = build(two_layers(divisions, **STITCH, slip_share=0.25))
    upper, _ = upper_nodes(problem)
    gap, slip, across = 0.3e-3, 0.2e-3, -0.1e-3
    move(problem, upper, slip, across, gap)
    problem.contacts.refresh()
    exact = -OPENING * 72e-6 * np.array([0.25 * slip, 0.25 * across, gap])
    residual = COMM.allreduce(problem.contacts.layers[0].residual()[1].sum(axis=0))
    assert -residual == pytest.approx(exact, rel=1e-10)


def slip_to(problem, upper, slip):
    """An accepted step to a slip in m, the layers a tenth of a millimetre apart; the pull on the upper one in N."""
    move(problem, upper, slip, 0.0, 0.1e-3)
    problem.contacts.refresh()
    step_of(problem).commit()
    return -COMM.allreduce(problem.contacts.layers[0].residual()[1].sum(axis=0))


@pytest.mark.parametrize("divisions", PARTS.values(), ids=PARTS)
def test_stitches_remember_a_slip_over_elements(divisions):
    """The pull grows by the slip of each step, on what overlaps then."""
    problem, _ = build(two_layers(divisions, **STITCH, slip_share=0.25))
    layer, (upper, _) = problem.contacts.layers[0], upper_nodes(problem)
    for slip in 0.45e-3 * np.arange(1, 8):
        pull = slip_to(problem, upper, slip)
        overlap = (12e-3 - slip) * 6e-3
        assert pull == pytest.approx(-OPENING * overlap * np.array([0.25 * slip, 0, 0.1e-3]), rel=1e-8, abs=1e-9)
        slips = np.linalg.norm(layer.slip, axis=1)[layer.face.owned()]
        assert max(COMM.allgather(slips.max(initial=0.0))) == pytest.approx(slip, rel=1e-9)


def test_stitches_are_slack_again_when_the_layers_are_back():
    """Also those at the edge that faced nothing on the way."""
    problem, _ = build(two_layers(PARTS["different"], **STITCH, slip_share=0.25))
    upper, _ = upper_nodes(problem)
    out = [slip_to(problem, upper, slip) for slip in (1e-3, 2e-3, 3e-3)]
    back = [slip_to(problem, upper, slip) for slip in (2e-3, 1e-3, 0.0)]
    assert back[0] == pytest.approx(out[1], rel=1e-6)
    assert back[1] == pytest.approx(out[0], rel=1e-6)
    assert abs(back[2][0]) < 1e-6 * abs(out[0][0])
