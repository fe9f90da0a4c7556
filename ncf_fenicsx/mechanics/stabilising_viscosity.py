"""A viscosity that stabilises a stack which snaps: it resists what departs from a drift, the motion before the trouble.

Were it to resist all motion, its force in the even motion under a tool would already be per cents of the tool's.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression


class Viscosity:
    """A force per volume against motion.

    Args:
        displacement: trial displacement in m.
        coefficient: constant, force per volume and speed in Pa s/m2.
        inverse_time_step: constant, 1 over the step's size in 1/s.
    """

    def __init__(self, displacement: Any, coefficient: Any, inverse_time_step: Any) -> None:
        self.coefficient = coefficient
        self._expected = fem.Function(displacement.function_space)
        self._force = coefficient * inverse_time_step * (displacement - self._expected)

    def work(self, variation: Expression) -> Expression:
        """Virtual work (J/m3) of the force for a variation of the displacement (m)."""
        return ufl.inner(self._force, variation)

    def expect(self, displacement: NDArray[np.float64]) -> None:
        """Take the displacement (m), at this rank's local dofs, that the drift would lead to by the step's end."""
        self._expected.x.array[:] = displacement
