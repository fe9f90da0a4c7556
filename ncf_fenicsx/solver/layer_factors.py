"""Factors of the parts of a stack: all heights together, what the layers do alike, and each layer by itself.

What couples layers are contact forces, which act on heights; what makes a layer stiff are its fibres, which act within
it. So an approximate solution first lets all heights of the stack follow the load, then what all layers do alike, where
that is worth its time, then each layer all of its displacements. GMRES makes it exact. A layer of one element has a
fourth of the unknowns of four layers, and the factors of a column of elements grow with the square of its unknowns: for
four layers the parts take about a third of the memory of factors of the whole, and a tenth of the work.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.solver.column_motions import ColumnMotions, motions_of_columns
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.modes import LowestMode

HEIGHTS = 0
"""Number of the part that all heights are; those of the layers follow."""
ALONE = 9
"""Applications between two factorisations, of a correction, up to which heights and layers do without the columns:
their factors cost as much as some Krylov steps on coarse meshes."""


class LayerFactors:
    """An approximate inverse of a stack's tangent.

    Args:
        comm: ranks that share the tangent.
        symmetric: LDL^T if so, else LU.
        positions: of this rank's owned nodes in m, shape (nodes, 3).
        sublaminates: layer of each of this rank's owned nodes; layers that share nodes count as one.
        first: global number of its first dof.
        constrained: its owned dofs whose displacement is given.

    Attributes:
        preconditioner: PETSc's, that applies them.
    """

    exact = lasts = False
    rough = 1e-4  # 1e-3 leaves fibres strained by what stays of it: iterations go from 20 to 60 on some meshes
    tolerance = 1e-5

    def __init__(
        self,
        comm: Any,
        symmetric: bool,
        positions: NDArray[np.float64],
        sublaminates: NDArray[np.int64],
        first: int,
        constrained: NDArray[np.int32],
    ) -> None:
        layers = max(comm.tompi4py().allgather(int(sublaminates.max(initial=0)))) + 1
        dofs = first + np.arange(3 * len(sublaminates)).reshape(-1, 3)

        def part(numbers: NDArray[np.int64]) -> Any:
            return PETSc.IS().createGeneral(numbers.ravel().astype(PETSc.IntType), comm)

        self._kinds = [part(dofs[:, 2]), *(part(dofs[sublaminates == layer]) for layer in range(layers))]
        self._factors = [DirectFactors(comm, symmetric, "ncf_part_") for _ in self._kinds]
        self._symmetric = symmetric
        self._columns: ColumnMotions | None = None
        self._motions_of_columns = partial(motions_of_columns, comm, positions, sublaminates, layers, constrained)
        self._applied, self._alone = 0, True
        self._matrix: Any = None
        self._mode, self._motions = LowestMode(constrained), list[Any]()
        self._residual: Any = None
        self._drop_blocks()
        self.preconditioner = PETSc.PC().create(comm)
        self.preconditioner.setType("python")
        self.preconditioner.setPythonContext(self)

    def _drop_blocks(self) -> None:
        self._blocks: list[Any] = [None] * len(self._kinds)

    def factorise(self, matrix: Any) -> int:
        """Factors of all parts of a matrix; PETSc's reason why there are none, 0 if there are."""
        return self._factorise(matrix, list(range(len(self._kinds))))

    def renew(self, matrix: Any) -> int:
        """Factors of the heights, which contact acts on, and of columns that join now; others are of an earlier one."""
        return self._factorise(matrix, [HEIGHTS])

    def _factorise(self, matrix: Any, parts: list[int]) -> int:
        joins, self._applied = self._alone and self._applied > ALONE, 0
        self._matrix = matrix
        self.preconditioner.setOperators(matrix)
        for number in parts:
            kind = self._kinds[number]
            self._blocks[number] = matrix.createSubMatrix(kind, kind, self._blocks[number])
        if self._residual is None:  # kept: what is dropped on several ranks is not freed at once
            self._residual, self._motions = matrix.createVecRight(), [block.createVecRight() for block in self._blocks]
        failed = [self._factors[number].factorise(self._blocks[number]) for number in parts]
        if joins:
            self.join_columns()
        if self._columns and (joins or len(parts) > 1) and self._columns.factorise(matrix):
            self._columns = None  # the others do without them
        return max(failed)

    def join_columns(self) -> None:
        """Let what all layers do alike follow the load, too, from the next factors of all parts on."""
        space, self._alone = self._motions_of_columns(), False
        self._columns = ColumnMotions(self._symmetric, space) if space else None

    def forget(self) -> None:
        """Forget all, the order of elimination included."""
        for factors in self._factors:
            factors.forget()
        if self._columns:
            self._columns.forget()
        self._drop_blocks()

    def apply(self, preconditioner: Any, b: Any, x: Any) -> None:
        """All heights, then the columns, then the layers side by side follow what is left of the load."""
        del preconditioner
        self._applied += 1
        x.set(0.0)
        self._follow(HEIGHTS, b, x)
        self._leave(b, x)
        if self._columns:
            self._columns.follow(self._residual, x)
            self._leave(b, x)
        for layer in range(HEIGHTS + 1, len(self._kinds)):
            self._follow(layer, self._residual, x)

    def _leave(self, b: Any, x: Any) -> None:
        """What a displacement x leaves of the load b."""
        self._matrix.mult(x, self._residual)
        self._residual.aypx(-1.0, b)

    def _follow(self, number: int, b: Any, x: Any) -> None:
        """Add to x how a part follows the load b."""
        part, motion = self._kinds[number], self._motions[number]
        load, total = b.getSubVector(part), x.getSubVector(part)
        self._factors[number].solve(load, motion)
        total.axpy(1.0, motion)
        b.restoreSubVector(part, load)
        x.restoreSubVector(part, total)

    def count_negative(self, matrix: Any) -> int:
        """The most negative pivots of any part, with LDL^T: the whole has at least as many negative eigenvalues.

        Layers that wave together do so in a mode of the whole that no part has; where one is found, it counts as one.
        """
        most = max(factors.count_negative(block) for factors, block in zip(self._factors, self._blocks, strict=True))
        if most:
            return most
        applied = self._applied
        found = self._mode.curvature(matrix, self.preconditioner.apply) < 0
        self._applied = applied  # the search is no correction
        return int(found)
