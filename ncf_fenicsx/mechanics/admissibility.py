"""What makes a trial state impossible although forces balance: inverted elements, Vf outside its range."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression, deformation_gradient
from ncf_fenicsx.mesh import StackMesh, compat
from ncf_fenicsx.mesh.hexahedra import point_in_words
from ncf_fenicsx.mesh.state_fields import StateField

Floats = NDArray[np.float64]


class Admissibility:
    """Looks at points of the cells for what no state may have.

    Args:
        stack: the mesh.
        displacement: trial displacement in m.
        points: reference points of a cell.
        volume_fraction: field of state at those points that is checked too; None in a solid.
        packing_limit: Vf that no state may reach, and whose limit it is.
    """

    def __init__(
        self,
        stack: StackMesh,
        displacement: Any,
        points: Floats,
        volume_fraction: StateField | None,
        packing_limit: tuple[float, str],
    ) -> None:
        self.stack, self.volume_fraction, self.packing_limit = stack, volume_fraction, packing_limit
        self.comm: MPI.Comm = stack.mesh.comm
        self._points = points
        self._cells = np.arange(len(stack.layer), dtype=np.int32)
        self._volume_ratio = self._compiled(ufl.det(deformation_gradient(displacement)))

    def _compiled(self, expression: Expression) -> Any:
        return compat.compile_expression(expression, self._points)

    def violation(self) -> str | None:
        """In words, what is impossible and where; None if nothing is. Collective."""
        ratio = np.asarray(self._volume_ratio.eval(self.stack.mesh, self._cells))
        found = self._named("inverted elements, volume ratio J", ratio, ~(ratio > 0))
        if found is not None or self.volume_fraction is None:
            return found
        vf, (limit, whose) = self.volume_fraction.trial(), self.packing_limit
        return self._named(f"fibre volume fraction outside (0, {limit:.4g}) ({whose})", vf, ~((vf > 0) & (vf < limit)))

    def _named(self, what: str, values: Floats, wrong: NDArray[np.bool_]) -> str | None:
        entries = np.argwhere(wrong)
        counts = self.comm.allgather(len(entries))
        if not any(counts):
            return None
        x = self._compiled(compat.coordinates(self.stack.mesh))  # on all ranks together
        positions = np.asarray(x.eval(self.stack.mesh, self._cells)).reshape(*values.shape, 3)
        words = [
            f"{values[cell, point]:.3g} at {point_in_words(positions[cell, point])} "
            f"in layer {self.stack.layer[cell] + 1}"
            for cell, point in entries[:1]
        ]
        first = next(found[0] for found in self.comm.allgather(words) if found)
        return f"{what} at {sum(counts)} points, such as {first}"
