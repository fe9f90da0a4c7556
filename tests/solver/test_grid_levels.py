"""Coarser grids: what is linear on them is so on the nodes, bodies stay apart, what is given stays given."""

import numpy as np
import pytest
from assembled import COMM
from petsc4py import PETSc

from ncf_fenicsx.solver.grid_levels import Axis, Grid, between, grid_of, motions_of_grids

X = np.array([0.0, 1, 2, 4, 7, 11, 16, 22, 29, 37]) * 1e-3
Y = np.linspace(0.0, 60e-3, 10)
BODIES = (np.linspace(0.0, 4e-3, 9), np.linspace(4e-3, 6e-3, 6))
"""Heights of nodes; the upper body rests on the lower one, so two levels stand at one height."""


def stack():
    """Positions and bodies of this rank's share of all nodes, in no order."""
    parts = [np.stack(np.meshgrid(X, Y, z, indexing="ij"), axis=-1).reshape(-1, 3) for z in BODIES]
    bodies = np.repeat([0, 1], [len(part) for part in parts])
    order = np.random.default_rng(0).permutation(len(bodies))
    own = np.array_split(order, COMM.size)[COMM.rank]
    return np.concatenate(parts)[own], bodies[own]


def coarse_nodes(grid):
    """Positions and bodies of all nodes of a grid, by global number."""
    x, y, z = grid.axes
    places = np.stack(np.meshgrid(x.places, y.places, z.places, indexing="ij"), axis=-1).reshape(-1, 3)
    bodies = np.broadcast_to(z.parts, grid.numbers.shape).ravel()
    order = np.argsort(grid.numbers.ravel())
    return places[order], bodies[order]


def field(positions, bodies):
    """Linear in each body, of all six in another way."""
    slopes = np.array([[[1, 2, 3], [-2, 1, 5], [4, -3, 2]], [[-1, 7, 3], [6, 1, -5], [2, 2, 9]]])
    return np.einsum("nij,nj->ni", slopes[bodies], positions) + 0.01 * bodies[:, None]


def moved(motions, coarse):
    """What matrices make of the displacements of the coarsest grid's nodes, on this rank's finest ones."""
    vector = motions[-1].createVecRight()
    vector.array[:] = coarse[slice(*vector.getOwnershipRange())]
    for matrix in reversed(motions):
        finer = matrix.createVecLeft()
        matrix.mult(vector, finer)
        vector = finer
    return vector.array_r.reshape(-1, 3).copy()


def all_grids(constrained=()):
    positions, bodies = stack()
    grid = grid_of(COMM, positions, bodies, np.array(constrained, dtype=np.int32))
    grids = [grid]
    while (kept := grids[-1].kept()) is not None:
        grids.append(grids[-1].coarser(kept))
    return positions, bodies, grids, motions_of_grids(PETSc.COMM_WORLD, grid)


def test_what_is_linear_in_each_body_is_so_on_all_grids():
    positions, bodies, grids, motions = all_grids()
    assert len(motions) == len(grids) - 1 > 0
    coarse = field(*coarse_nodes(grids[-1])).ravel()
    assert moved(motions, coarse) == pytest.approx(field(positions, bodies), abs=1e-15)


def test_bodies_do_not_move_each_other():
    _, bodies, grids, motions = all_grids()
    upper = coarse_nodes(grids[-1])[1] == 1
    rise = moved(motions, np.repeat(upper, 3).astype(float))
    assert (rise == (bodies == 1)[:, None]).all()


def test_what_is_given_is_moved_by_no_grid():
    positions, _ = stack()
    held = np.flatnonzero((positions[:, 0] == 0.0) | (positions[:, 1] == 0.0))
    constrained = 3 * held + np.where(positions[held, 0] == 0.0, 0, 1)
    _, _, grids, motions = all_grids(constrained)
    rise = moved(motions, np.ones(3 * grids[-1].numbers.size))
    assert (rise.ravel()[constrained] == 0.0).all()
    first = moved(motions[:1], np.ones(3 * grids[1].numbers.size))
    far = (positions[:, 0] > X[2]) & (positions[:, 1] > Y[2])
    assert far.any()
    assert first[far] == pytest.approx(1.0, abs=1e-14)


def test_lines_that_are_near_go_first():
    _, _, grids, _ = all_grids()
    counts = [grid.numbers.shape for grid in grids]
    assert counts[0] == (10, 10, 15)
    assert counts[1][:2] == (10, 10)  # half a millimetre through, and 1 to 8 mm along
    assert counts[1][2] == 5 + 4


def test_lines_up_to_twice_as_far_apart_go_with_the_nearest():
    spacings, lines = (1.0, 2.0, 5.0), np.arange(13.0)
    axes = tuple(Axis(spacing * lines, np.zeros(13, dtype=np.int64)) for spacing in spacings)
    numbers = np.arange(13**3).reshape(13, 13, 13)
    grid = Grid(axes, numbers, np.array([0, 13**3]), np.ones((13**3, 3), dtype=bool))
    assert [len(lines) for lines in grid.kept()] == [7, 7, 13]


def test_each_node_stays_with_its_rank():
    positions, _, grids, _ = all_grids()
    coarse, _ = coarse_nodes(grids[1])
    own = coarse[slice(*grids[1].starts[COMM.rank : COMM.rank + 2])]
    mine = {tuple(place) for place in positions.round(9)}
    assert all(tuple(place) in mine for place in own.round(9))
    assert grids[1].starts[-1] == len(coarse)


def test_every_other_line_and_the_last_one_of_each_body():
    axis = Axis(np.array([0.0, 1, 2, 3, 3, 4, 5]), np.array([0, 0, 0, 0, 1, 1, 1]))
    assert axis.kept.tolist() == [0, 2, 3, 4, 6]
    ends, shares = between(axis.places, axis.kept)
    assert ends[1].tolist() == [0, 1]
    assert shares[1].tolist() == [0.5, 0.5]
    assert ends[5].tolist() == [3, 4]


@pytest.mark.parametrize("change", ["no order", "shifted", "missing", "twice"])
def test_other_nodes_are_no_grid(change):
    positions, bodies = stack()
    if change == "no order":
        positions = np.random.default_rng(COMM.rank).random((20_000, 3))
        bodies = np.zeros(len(positions), dtype=np.int64)
    elif change == "shifted":
        positions[:3, 0] += 0.3e-3 * np.arange(1, 4)
    elif change == "missing":
        positions, bodies = positions[1:], bodies[1:]
    else:
        positions[0] = positions[1]
    assert grid_of(COMM, positions, bodies, np.array([], dtype=np.int32)) is None
