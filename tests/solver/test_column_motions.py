"""What all layers do alike: motions of columns, of some of them on fine meshes, and where there are none."""

import numpy as np
import pytest
from assembled import layer_factors, tangent_of
from mpi4py import MPI

from ncf_fenicsx.solver.column_motions import _some

THICKNESS = 2e-3
"""Of a layer of the small scene in m."""


def columns_of(table):
    """Factors that the columns have joined, of a tangent, and that."""
    newton, matrix, *_ = tangent_of(table)
    factors = layer_factors(newton)
    factors.join_columns()
    assert factors.factorise(matrix) == 0
    return newton, matrix, factors


@pytest.mark.two_ranks
def test_columns_move_and_turn_alike_or_in_proportion_to_the_height(table):
    newton, _, factors = columns_of(table)
    space, moved = factors._columns._space, newton.unknown.duplicate()
    motion = space.createVecRight()
    first, last = motion.getOwnershipRange()
    sizes = np.array([1.0, 2.0, 3.0, 0.5, 0.25, 10.0, 20.0, 30.0, 5.0, 2.5])
    motion.array[:] = sizes[np.arange(first, last) % 10]
    space.mult(motion, moved)
    heights = newton.system.displacement.function_space.tabulate_dof_coordinates()[: len(moved.array) // 3, 2]
    layers = newton.system.sublaminates
    middles = (layers + 0.5) * THICKNESS
    turned, through = (heights - middles) / (THICKNESS / 2), heights / THICKNESS - 1
    expected = np.stack([1 + 0.5 * turned, 2 + 0.25 * turned, 3 + 0 * turned], axis=1)
    expected = (expected * (1 + 10 * through[:, None])).ravel()
    expected[newton._constrained] = 0.0
    assert moved.array == pytest.approx(expected)


@pytest.mark.two_ranks
def test_every_other_line_of_columns_leaves_what_is_linear_between_them(table, monkeypatch):
    monkeypatch.setattr("ncf_fenicsx.solver.column_motions.LEAST_LINES", 1)
    monkeypatch.setattr("ncf_fenicsx.solver.column_motions.APART", 2)
    newton, _, factors = columns_of(table)
    space, moved = factors._columns._space, newton.unknown.duplicate()
    points = newton.system.displacement.function_space.tabulate_dof_coordinates()[: len(moved.array) // 3]
    lines = np.unique(np.concatenate(MPI.COMM_WORLD.allgather(points[:, 0])).round(9))
    assert (len(lines), space.getSize()[1]) == (7, 10 * 4 * 2)
    motion = space.createVecRight()
    numbers = np.arange(*motion.getOwnershipRange())
    motion.array[:] = np.where(numbers % 10 == 2, lines[::2][numbers // 20], 0.0)  # heights, two lines along y
    space.mult(motion, moved)
    expected = np.stack([0 * points[:, 0], 0 * points[:, 0], points[:, 0]], axis=1).ravel()
    expected[newton._constrained] = 0.0
    assert moved.array == pytest.approx(expected, abs=1e-8)


def test_columns_solve_for_a_motion_of_their_own(table):
    newton, matrix, factors = columns_of(table)
    space, wanted, load = factors._columns._space, newton.unknown.duplicate(), newton.unknown.duplicate()
    motion = space.createVecRight()
    motion.array[:] = np.sin(np.arange(*motion.getOwnershipRange()) + 1.0)
    space.mult(motion, wanted)
    matrix.mult(wanted, load)
    found = load.duplicate()
    factors._columns.follow(load, found)
    found.axpy(-1.0, wanted)
    assert found.norm() < 1e-6 * wanted.norm()


@pytest.mark.parametrize("through", [1, 3])
def test_layers_whose_nodes_do_not_stand_above_each_other_have_no_columns(table, through):
    change = {"divisions": [[6, 2], [8, 3]], "through": through}
    *_, factors = columns_of(table | {"stack": table["stack"] | change})
    assert factors._columns is None


def test_columns_without_factors_leave(table, monkeypatch):
    monkeypatch.setattr("ncf_fenicsx.solver.column_motions.ColumnMotions.factorise", lambda *_: 1)
    *_, factors = columns_of(table)
    assert factors._columns is None


def test_fine_meshes_take_some_lines_of_columns():
    assert [len(_some(lines)) for lines in (2, 7, 27, 28, 56, 165)] == [2, 7, 27, 15, 15, 42]
