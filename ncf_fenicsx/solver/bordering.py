"""Newton's step with the heights of tools under force control among its unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.contact.force_control import ForceControl

Floats = NDArray[np.float64]


def border(step: Any, controls: Sequence[ForceControl], solve: Callable[[Any, Any], None], constrained: Any) -> Floats:
    """Correct a step u = K^-1 r for unknown heights h: both K u + C h = r and R u + S h = e hold then.

    K is the tangent, whose factors are at hand; C, R and S are the columns, rows and stiffnesses of the controls, e is
    their excess of force.

    Args:
        step: u in m; corrected in place.
        controls: the equations.
        solve: solves K x = b for vectors b and x.
        constrained: local dofs whose displacement is given.

    Returns:
        The heights in m.
    """
    columns, rows = [], []
    for control in controls:
        column, row, solved = step.duplicate(), step.duplicate(), step.duplicate()
        column.array[:], row.array[:] = control.column(), control.row()
        column.array[constrained] = row.array[constrained] = 0.0
        solve(column, solved)
        columns.append(solved)
        rows.append(row)
    schur = -np.array([[row.dot(column) for column in columns] for row in rows]).reshape(len(rows), len(columns))
    schur += np.diag([control.stiffness() for control in controls])
    excess = np.array([control.excess() - row.dot(step) for control, row in zip(controls, rows, strict=True)])
    heights: Floats = np.linalg.lstsq(schur, excess, rcond=None)[0]
    for column, height in zip(columns, heights, strict=True):
        step.axpy(-height, column)
    return heights
