"""Flat plate, larger than the stack."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.tools.rigid_surface import Tool


class Plate(Tool):
    """Rigid horizontal plate without edges, pressing downwards."""

    kind = "plate"

    def signed_distance(self, point: Expression) -> Expression:
        """Height of the plate over the point in m."""
        return -point[2]

    def section(self) -> NDArray[np.float64]:
        """Straight line over any stack, in m, shape (points, 2)."""
        return np.array([[-10.0, 0.0], [10.0, 0.0]])
