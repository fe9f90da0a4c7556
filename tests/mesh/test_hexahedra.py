"""Hexahedra of a stack: grading, parts for ranks."""

import numpy as np
import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh import hexahedra
from ncf_fenicsx.mesh.stack_mesh import stack_of

pytestmark = pytest.mark.serial


def test_grading_follows_its_formula_on_both_sides_of_the_focus():
    s = np.linspace(0, 1, 31)
    assert hexahedra.graded(30, 0.03, 0.0, 0.8) == pytest.approx(0.03 * (0.2 * s + 0.8 * s**2))
    both = hexahedra.graded(8, 1.0, 0.5, 0.8)
    assert both == pytest.approx(1 - both[::-1])
    assert both[4] == 0.5
    assert np.all(np.diff(both) > 0)
    assert hexahedra.graded(5, 2.0, 2.0, 0.5) == pytest.approx(2 - hexahedra.graded(5, 2.0, 0.0, 0.5)[::-1])
    assert hexahedra.graded(1, 1.0, 0.5, 0.5) == pytest.approx([0, 1])


@pytest.mark.parametrize("parts", [1, 2, 3, 7])
def test_parts_hold_whole_columns_of_about_equal_size(parts):
    stack = stack_of(Scene.from_table({"tool": {}, "stack": {"divisions": [9, 7]}}))
    part = hexahedra.columns(stack, parts)
    centres = stack.points[stack.cells].mean(axis=1)
    column = np.unique(np.round(centres[:, :2] * 1e7), axis=0, return_inverse=True)[1].ravel()
    for number in range(column.max() + 1):
        assert len(set(part[column == number])) == 1
    sizes = np.bincount(part, minlength=parts)
    assert sizes.min() > 0.7 * sizes.max()
