"""How far the pressure at the end of a step is off because the step is as long as it is.

At each point the step is taken again in two halves by the laws themselves, along the parabola through its Vf0 / Vf at
the end, at the start, and one step before. What the pressure then differs by is the local error in time to leading
order: of a speed that is the mean over the step, and of branches that relax while the pressure does not grow evenly.
"""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.fabric import Fabric
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.state_fields import Location, StateField, at_volume_points, functions_at_points

Floats = NDArray[np.float64]


class TimeError:
    """Estimates the local error in time of a problem whose laws follow time.

    Args:
        problem: with a fabric.

    Attributes:
        state: Vf one step before the last, the size of the last step in s, and the largest pressure so far.
    """

    def __init__(self, problem: Problem) -> None:
        material = problem.material
        assert isinstance(material, Fabric)
        self._comm = problem.comm
        initial = {"volume_fraction": problem.scene.stack.initial_volume_fraction}
        earlier = functions_at_points(problem.mesh, at_volume_points(problem.stack.element), initial)["volume_fraction"]
        self._weight, self._ratio = problem.constants(0.0), problem.constants(0.0)
        kinematics, vf0 = material.kinematics(problem.displacement), material.initial_volume_fraction
        start = material.states["volume_fraction"]
        first, last = vf0 / start, vf0 / kinematics.volume_fraction
        middle = (first + last) / 2 - self._weight * ((last - first) - self._ratio * (first - vf0 / earlier))
        pressure = material.pressure(kinematics)
        difference = abs(material.pressure_in_halves(kinematics, vf0 / middle) - pressure)
        self._error_form = compat.compile_form(difference * problem.volumes.all)
        self._pressure_form = compat.compile_form(abs(pressure) * problem.volumes.all)
        self._size = self._pressure = 0.0
        entries = start.function_space.dofmap.list
        self._numbers = StateField("time_error.numbers", Location.EVERYWHERE, np.zeros(2), self._end_of_step)
        self.state = [
            StateField(
                "time_error.earlier_volume_fraction",
                Location.CELLS,
                earlier.x.array,
                lambda: start.x.array[entries],
                entries=entries,
            ),
            self._numbers,
        ]

    def begin(self, size: float, same_way: bool) -> None:
        """Take the size (s) of a step, and whether tools go on as in the last one: else its motion tells nothing."""
        last = float(self._numbers.committed[0])
        self._size = size
        self._weight.value = size / (4 * (size + last)) if same_way and last and size else 0.0
        self._ratio.value = size / last if last else 0.0

    def relative(self) -> float:
        """Error of the pressure over the largest so far, both as means over the volume; collective."""
        parts = [float(fem.assemble_scalar(form)) for form in (self._error_form, self._pressure_form)]
        error, self._pressure = self._comm.allreduce(np.array(parts))
        largest = max(self._pressure, float(self._numbers.committed[1]))
        return float(error / largest) if self._size and largest else 0.0

    def _end_of_step(self) -> Floats:
        return np.array([self._size, max(self._pressure, float(self._numbers.committed[1]))])
