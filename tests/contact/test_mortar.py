"""Dual mortar weights between faces that mesh differently: fields, loads, areas."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from ncf_fenicsx.contact.mortar import dual_weights, integrals, normalised
from ncf_fenicsx.mesh.hexahedra import graded

pytestmark = pytest.mark.serial

RNG = np.random.default_rng(7)
SYMMETRIES = np.array(
    [[0, 1, 2, 3], [1, 3, 0, 2], [3, 2, 1, 0], [2, 0, 3, 1], [1, 0, 3, 2], [0, 2, 1, 3], [2, 3, 0, 1], [3, 1, 2, 0]]
)
NEVER = -1.0
"""A tolerance at which no elements match, so that all are clipped."""


def grid(x, y):
    Y, X = np.meshgrid(y, x, indexing="ij")
    node = np.arange(X.size).reshape(X.shape)
    corners = [node[j : j + len(y) - 1, i : i + len(x) - 1].ravel() for j, i in np.ndindex(2, 2)]
    return np.stack([X.ravel(), Y.ravel()], axis=1), np.stack(corners, axis=1)


def square(divisions, lift=0.0):
    x = np.linspace(0, 1, divisions + 1)
    return grid(x + lift, x)


def distorted(positions, quads):
    """Moved inside the unit square, where the boundary stays."""
    wave = np.sin(np.pi * positions[:, :1]) * np.sin(np.pi * positions[:, 1:])
    return positions + 0.06 * wave * np.sin(9 * positions[:, ::-1] + 3 * positions), quads


def rotated(positions, quads, angle, about=(0.5, 0.5)):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return (positions - about) @ turn.T + about, quads


def shuffled(positions, quads):
    """The same mesh with other node numbers, another order of elements, and elements turned and turned over."""
    number = RNG.permutation(len(positions))
    renumbered = np.empty_like(positions)
    renumbered[number] = positions
    turned = np.take_along_axis(number[quads], SYMMETRIES[RNG.integers(8, size=len(quads))], axis=1)
    return renumbered, RNG.permutation(turned), number


FINE = square(7)
MESHES = {
    "coarser": (FINE, square(4)),
    "finer": (square(3), square(11)),
    "graded": (FINE, grid(graded(6, 1.0, 0.0, 0.8), graded(9, 1.0, 0.3, 0.6))),
    "distorted_master": (FINE, distorted(*square(5))),
    "distorted_slave": (distorted(*square(5)), FINE),
    "distorted_both": (distorted(*square(8)), distorted(*square(7))),
    "turned_over": (shuffled(*FINE)[:2], shuffled(*distorted(*square(9)))[:2]),
}
SLIPPED = {
    "overhang": (FINE, square(5, lift=0.33)),
    "sheared": (FINE, rotated(*square(6), 0.3)),
    "distorted_overhang": (distorted(*square(6)), rotated(*distorted(*square(7)), -0.2, about=(0.1, 0.2))),
}


def linear(positions):
    return 3.0 + 2.0 * positions[:, 0] - 5.0 * positions[:, 1]


def areas(positions, quads):
    """Integral of each node's shape function, by the product rule on affine elements."""
    corners = positions[quads]
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]) / 4
    return np.bincount(quads.ravel(), np.repeat(area, 4), len(positions))


def hat_integrals(x, low, high):
    """Integrals of the hats on the sorted nodes x over [low, high]."""
    cuts = np.unique(np.clip(np.concatenate([x, [low, high]]), max(low, x[0]), min(high, x[-1])))
    middle, width = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts)
    return np.array([width @ np.interp(middle, x, unit) for unit in np.eye(len(x))])


@pytest.mark.parametrize("tolerance", [1e-6, NEVER])
@pytest.mark.parametrize("mesh", [FINE, grid(graded(6, 1.0, 0.0, 0.8), graded(5, 2.0, 0.7, 0.6)), distorted(*FINE)])
def test_matching_meshes_pair_node_by_node(mesh, tolerance):
    slave = shuffled(*mesh)[:2]
    positions, quads, number = shuffled(*slave)
    weights = dual_weights(*slave, positions, quads, tolerance)
    pairs = csr_matrix((np.ones(len(number)), (np.arange(len(number)), number)), (len(number), len(number)))
    assert weights.rows.nnz == len(number)
    assert abs(weights.rows - pairs).max() == 0
    assert weights.coverage == pytest.approx(np.ones(len(number)), abs=1e-14)


@pytest.mark.parametrize("name", [*MESHES, *SLIPPED])
def test_rows_add_up_to_one_and_take_linear_fields_to_slave_nodes(name):
    slave, master = (MESHES | SLIPPED)[name]
    coupling, covered, whole = integrals(*slave, *master)
    weights = normalised(coupling, covered, whole)
    seen = weights.coverage > 0
    sums = np.asarray(weights.rows.sum(axis=1)).ravel()
    assert sums == pytest.approx(seen.astype(float), abs=1e-14)
    assert np.array_equal(np.diff(weights.rows.indptr) > 0, seen)
    assert coupling @ linear(master[0]) == pytest.approx(covered * linear(slave[0]), abs=1e-13)
    # weights below 1e-8 are left out; there are none of these where elements are rectangles
    accuracy = 1e-7 if "distorted" in name or name == "turned_over" else 1e-10
    assert (weights.rows @ linear(master[0]))[seen] == pytest.approx(linear(slave[0])[seen], abs=accuracy)


@pytest.mark.parametrize("name", MESHES)
def test_faces_of_one_outline_cover_each_other(name):
    slave, master = MESHES[name]
    coupling, covered, whole = integrals(*slave, *master)
    assert normalised(coupling, covered, whole).coverage == pytest.approx(np.ones(len(slave[0])), abs=1e-14)
    assert whole.sum() == pytest.approx(1, abs=1e-12)
    loads = coupling.T @ np.ones(len(slave[0]))
    assert loads.sum() == pytest.approx(1, abs=1e-12)
    assert loads @ master[0] == pytest.approx([0.5, 0.5], abs=1e-12)


@pytest.mark.parametrize("slave_x", [np.linspace(0, 1, 8), graded(9, 1.0, 0.4, 0.7)])
@pytest.mark.parametrize("lift", [0.0, 1 / 7, 0.33, -0.45])
@pytest.mark.parametrize("tolerance", [1e-6, NEVER])
def test_a_uniform_pressure_loads_the_master_consistently(slave_x, lift, tolerance):
    y, master_x, master_y = np.linspace(0, 1, 6), np.linspace(0, 1, 6) + lift, graded(7, 1.0, 0.2, 0.5)
    slave, master = grid(slave_x, y), grid(master_x, master_y)
    weights = dual_weights(*slave, *master, tolerance)
    expected = np.outer(hat_integrals(master_y, 0, 1), hat_integrals(master_x, 0, 1)).ravel()
    assert weights.rows.T @ (areas(*slave) * weights.coverage) == pytest.approx(expected, abs=1e-10)
    covered = np.outer(hat_integrals(y, 0, 1), hat_integrals(slave_x, *master_x[[0, -1]])).ravel()
    assert areas(*slave) * weights.coverage == pytest.approx(covered, abs=1e-10)


def test_distorted_faces_that_overhang_share_area_and_moment():
    outline = np.array([[0.3, 0.2], [1.0, 1.0]])
    slave, (positions, quads) = distorted(*square(12)), distorted(*square(9))
    master = positions + outline[0], quads
    coupling, covered, _ = integrals(*slave, *master)
    loads = coupling.T @ np.ones(len(slave[0]))
    area = np.prod(outline[1] - outline[0])
    assert covered.sum() == pytest.approx(area, rel=2e-3), "slivers of slave elements are left out"
    assert loads.sum() == pytest.approx(covered.sum(), rel=1e-12)
    assert loads @ master[0] == pytest.approx(covered @ slave[0], rel=1e-12)
    assert loads @ master[0] == pytest.approx(area * outline.mean(axis=0), rel=4e-3)


def test_turned_faces_overlap_in_a_regular_octagon():
    slave, master = square(10), rotated(*square(13), np.pi / 4)
    _, covered, whole = integrals(*slave, *master)
    assert whole.sum() == pytest.approx(1, abs=1e-12)
    assert covered.sum() == pytest.approx(2 * np.sqrt(2) - 2, rel=2e-3), "slivers of slave elements are left out"


def test_slivers_count_as_open():
    slave, master = square(1), square(1, lift=0.96)
    weights = dual_weights(*slave, *master)
    assert weights.rows.nnz == 0
    assert np.all(weights.coverage == 0)
    assert dual_weights(*slave, *square(1, lift=0.94)).rows.nnz


@pytest.mark.parametrize("tolerance", [1e-6, NEVER])
def test_a_slip_by_one_element_pairs_the_next_nodes(tolerance):
    slave = square(5)
    weights = dual_weights(*slave, *square(5, lift=0.2), tolerance)
    node = np.arange(36).reshape(6, 6)
    assert np.all(np.diff(weights.rows.indptr)[node[:, 0]] == 0)
    assert weights.coverage[node] == pytest.approx(np.tile([0, 0.5, 1, 1, 1, 1], (6, 1)), abs=1e-12)
    assert np.array_equal(weights.rows[node[:, 1:].ravel()].toarray(), np.eye(36)[node[:, :-1].ravel()])


def test_slips_within_the_tolerance_pair_nodes():
    lifted = square(5, lift=0.2 * 0.009)
    paired = dual_weights(*square(5), *lifted, tolerance=0.01)
    assert np.array_equal(paired.rows.toarray(), np.eye(36))
    assert np.all(paired.coverage == 1)
    assert dual_weights(*square(5), *lifted, tolerance=0.008).rows.nnz > 36


def test_the_tolerance_is_measured_by_the_shortest_edge():
    x = np.array([0.0, 0.01, 1.0])
    slave, master = grid(x, [0.0, 1.0]), grid(x + 0.001, [0.0, 1.0])
    rows = dual_weights(*slave, *master, tolerance=0.01).rows.toarray()
    assert rows[2] == pytest.approx(np.eye(6)[2], abs=1e-15)
    assert np.count_nonzero(rows[0]) > 1


@pytest.mark.parametrize("divisions", [6, 7])
def test_a_slip_by_half_an_element_is_symmetric(divisions):
    n = divisions + 1
    rows = dual_weights(*square(divisions), *square(divisions, lift=0.5 / divisions)).rows.toarray()
    inner = rows.reshape(n, n, n, n)[3, 3]
    # by hand along x, with psi = 2 - 3 s and 3 s - 1 on each slave element
    assert inner[3, 1:5] == pytest.approx(np.array([-1, 9, 9, -1]) / 16, abs=1e-12)
    assert not inner[np.arange(n) != 3].any()
    # the other way round the same slip mirrors the weights
    back = dual_weights(*square(divisions), *square(divisions, lift=-0.5 / divisions)).rows.toarray()
    assert back.reshape(n, n, n, n)[:, ::-1, :, ::-1] == pytest.approx(rows.reshape(n, n, n, n), abs=1e-12)


def along(slip):
    """Weights of the four master nodes about a slave node in one direction, elements of length one, by Simpson's rule.

    The dual function of the node is 2 - 3 |t| on both elements at it, and its integral is one.
    """
    cuts = np.array([-1, slip - 1, 0, slip, 1])
    middle, width = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts)
    node = slip + np.arange(-2, 2)[:, None]
    low, centre, high = ((2 - 3 * abs(t)) * np.maximum(1 - abs(t - node), 0) for t in (cuts[:-1], middle, cuts[1:]))
    return (low + 4 * centre + high) @ width / 6


@pytest.mark.parametrize("slip", [(0.5, 0.5), (0.3, 0.4), (0.05, 0.9)])
def test_slips_in_two_directions_multiply_their_weights(slip):
    x = np.arange(7.0)
    inner = dual_weights(*grid(x, x), *grid(x + slip[0], x + slip[1])).rows.toarray().reshape(7, 7, 7, 7)[3, 3]
    assert along(0.5) == pytest.approx(np.array([-1, 9, 9, -1]) / 16)
    assert inner[1:5, 1:5] == pytest.approx(np.outer(along(slip[1]), along(slip[0])), abs=1e-12)


def test_elements_of_several_ranks_add_up():
    slave, master = SLIPPED["distorted_overhang"]
    at_once = integrals(*slave, *master)
    parts = [integrals(slave[0], quads, *master) for quads in np.array_split(slave[1], 3)]
    for together, *single in zip(at_once, *parts, strict=True):
        assert abs(together - sum(single)).max() == pytest.approx(0, abs=1e-15)


def test_ranks_without_elements_and_faces_apart_give_nothing():
    nothing = np.zeros((0, 4), dtype=np.int64)
    for slave, master in ((nothing, FINE[1]), (FINE[1], nothing), (nothing, nothing)):
        coupling, covered, _ = integrals(FINE[0], slave, FINE[0], master)
        assert coupling.shape == (64, 64)
        assert coupling.nnz == 0
        assert not covered.any()
    apart = dual_weights(*FINE, *square(4, lift=2.0))
    assert apart.rows.nnz == 0
    assert not apart.coverage.any()


def test_nodes_away_from_the_faces_are_no_partners():
    positions, quads = FINE
    around = np.concatenate([positions + 1e-3, positions])[::-1]
    exact = dual_weights(positions, quads, around, 63 - quads, tolerance=0.01).rows
    assert np.array_equal(exact.toarray(), np.eye(128)[::-1][64:])
    moved = dual_weights(positions, quads, around, len(around) - 1 - quads, tolerance=0.01).rows
    assert np.array_equal(moved.toarray(), np.eye(128)[::-1][:64])
