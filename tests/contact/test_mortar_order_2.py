"""Dual mortar weights of faces with nine nodes an element, also against faces of four."""

import numpy as np
import pytest

from ncf_fenicsx.contact.face_overlaps import PlanElements
from ncf_fenicsx.contact.mortar import dual_weights, integrals, normalised

pytestmark = pytest.mark.serial

NEVER = -1.0
"""A tolerance at which no elements match, so that all are clipped."""


def grid(x, y, order=2):
    """Positions and elements over lines of nodes, of which every ``order``-th bounds elements."""
    Y, X = np.meshgrid(y, x, indexing="ij")
    node = np.arange(X.size).reshape(X.shape)
    starts = [(j, i) for j in range(0, len(y) - 1, order) for i in range(0, len(x) - 1, order)]
    elements = [node[j : j + order + 1, i : i + order + 1].ravel() for j, i in starts]
    return np.stack([X.ravel(), Y.ravel()], axis=1), np.array(elements)


def square(elements, lift=0.0, order=2):
    x = np.linspace(0, 1, order * elements + 1)
    return grid(x + lift, x, order)


def graded(elements):
    """Bounds that are unevenly spaced, with nodes halfway between them."""
    bounds = np.linspace(0, 1, elements + 1) ** 1.4
    return np.sort(np.concatenate([bounds, (bounds[1:] + bounds[:-1]) / 2]))


def wavy(positions, elements):
    """Moved inside the unit square; nodes are no longer halfway, and edges not straight."""
    wave = np.sin(np.pi * positions[:, :1]) * np.sin(np.pi * positions[:, 1:])
    return positions + 0.01 * wave * np.sin(9 * positions[:, ::-1] + 3 * positions), elements


def linear(positions):
    return 3.0 + 2.0 * positions[:, 0] - 5.0 * positions[:, 1]


def loads(x, order, low, high):
    """Integrals over [low, high] of the shape functions along a line of nodes, by Gauss's rule on parts of elements."""
    points, weights = np.polynomial.legendre.leggauss(4)
    total = np.zeros(len(x))
    for start in range(0, len(x) - 1, order):
        nodes = x[start : start + order + 1]
        a, b = max(low, nodes[0]), min(high, nodes[-1])
        if b <= a:
            continue
        s = (a + b) / 2 + (b - a) / 2 * points
        for number, at in enumerate(nodes):
            others = np.delete(nodes, number)
            shape = np.prod([(s - other) / (at - other) for other in others], axis=0)
            total[start + number] += (b - a) / 2 * weights @ shape
    return total


PAIRS = {
    "slipped by its outline": (square(4), square(4)),
    "coarser": (square(4), square(3)),
    "finer": (square(2), square(5)),
    "graded": (square(4), grid(graded(5), graded(3))),
    "on four nodes": (square(4), square(5, order=1)),
    "four nodes on nine": (square(5, order=1), square(3)),
    "overhang": (square(4), square(3, lift=0.33)),
    "overhang by elements": (square(4), square(4, lift=0.5)),
    "overhang on four nodes": (square(3), square(7, lift=-0.4, order=1)),
    "wavy": (wavy(*square(5)), wavy(*square(4))),
}


@pytest.mark.parametrize("name", PAIRS)
def test_rows_add_up_to_one_and_take_linear_fields_to_slave_nodes(name):
    slave, master = PAIRS[name]
    coupling, covered, whole = integrals(*slave, *master, NEVER)
    weights = normalised(coupling, covered, whole)
    seen = weights.coverage > 0
    assert np.asarray(weights.rows.sum(axis=1)).ravel() == pytest.approx(seen.astype(float), abs=1e-13)
    assert np.asarray(coupling.sum(axis=1)).ravel() == pytest.approx(covered, abs=1e-13)
    off = np.abs((weights.rows @ linear(master[0]))[seen] - linear(slave[0])[seen]).max()
    assert off < (2e-2 if name == "wavy" else 1e-7)  # what curved edges within straight pieces leave of it
    if "overhang" not in name:
        assert weights.coverage == pytest.approx(np.ones(len(slave[0])), abs=1e-12)


@pytest.mark.parametrize("slave_order", [1, 2])
@pytest.mark.parametrize("master_order", [1, 2])
@pytest.mark.parametrize("lift", [0.0, 0.25, -0.5])
def test_a_uniform_pressure_loads_the_master_as_its_shape_functions(slave_order, master_order, lift):
    """Slips by whole elements of the slave cover each of these or none of it."""
    slave_x, y = np.linspace(0, 1, 4 * slave_order + 1), np.linspace(0, 1, 3 * slave_order + 1)
    master_x = np.linspace(0, 1, 3 * master_order + 1) + lift
    master_y = graded(5) if master_order == 2 else graded(5)[::2]
    slave, master = grid(slave_x, y, slave_order), grid(master_x, master_y, master_order)
    coupling, covered, _ = integrals(*slave, *master, NEVER)
    low, high = max(0.0, lift), min(1.0, 1.0 + lift)
    expected = np.outer(loads(master_y, master_order, 0, 1), loads(master_x, master_order, low, high)).ravel()
    assert coupling.T @ np.ones(len(slave[0])) == pytest.approx(expected, abs=1e-9)
    taken = np.outer(loads(y, slave_order, 0, 1), loads(slave_x, slave_order, low, high)).ravel()
    assert covered == pytest.approx(taken, abs=1e-12)
    assert (expected.max() > 0.03) & (covered.min() >= 0)


@pytest.mark.parametrize("lift", [0.1, 0.33, 0.6])
def test_elements_that_hang_over_share_force_and_moment(lift):
    slave, master = square(4), square(3, lift=lift)
    coupling, covered, _ = integrals(*slave, *master)
    pushes = coupling.T @ np.ones(len(slave[0]))
    assert covered.min() >= 0
    assert covered.sum() == pytest.approx(1 - lift, rel=1e-2), "slivers of slave elements are left out"
    assert pushes.sum() == pytest.approx(covered.sum(), rel=1e-12)
    assert pushes @ master[0] == pytest.approx(covered @ slave[0], rel=1e-12)


@pytest.mark.parametrize("tolerance", [1e-6, NEVER])
def test_matching_elements_pair_node_by_node(tolerance):
    positions, elements = square(3)
    number = np.random.default_rng(3).permutation(len(positions))
    moved = np.empty_like(positions)
    moved[number] = positions
    weights = dual_weights(positions, elements, moved, number[elements][::-1], tolerance)
    dense = weights.rows.toarray()
    assert dense[np.arange(len(positions)), number] == pytest.approx(np.ones(len(positions)), abs=1e-12)
    assert np.count_nonzero(dense) == len(positions)
    assert weights.coverage == pytest.approx(np.ones(len(positions)), abs=1e-14)


def test_elements_of_nine_nodes_do_not_pair_with_those_of_four():
    positions, _ = square(2)
    weights = dual_weights(*square(2), *square(4, order=1))
    assert weights.rows.nnz > len(positions)
    assert weights.coverage == pytest.approx(np.ones(len(positions)), abs=1e-14)


def test_shares_of_a_rectangle_are_those_of_simpsons_rule():
    elements = PlanElements(*grid(np.linspace(0, 3, 3), np.linspace(0, 2, 3)))
    assert elements.shares[0] * 36 / 6 == pytest.approx([1, 4, 1, 4, 16, 4, 1, 4, 1])
