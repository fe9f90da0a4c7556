"""One nonlinear solve by Newton's method: the only room that knows PETSc."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx import compat
from ncf_fenicsx.scene import Solver as Settings
from ncf_fenicsx.supports import Supports
from ncf_fenicsx.timing import Phases

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
ADD, INSERT = PETSc.InsertMode.ADD, PETSc.InsertMode.INSERT
FORWARD, REVERSE = PETSc.ScatterMode.FORWARD, PETSc.ScatterMode.REVERSE


class Coupling(Protocol):
    """Forces between pairs of nodes, beside the compiled forms.

    Attributes:
        nodes: pairs of this rank's local nodes, shape (pairs, 2).
    """

    nodes: Integers

    def residual(self) -> Floats:
        """Residual of the pairs in N, shape (pairs, 2, 3)."""

    def tangent(self) -> Floats:
        """Tangent of the pairs in N/m, shape (pairs, 6, 6)."""


class System(Protocol):
    """What is solved: compiled forms, constraints, and a coupling of nodes beside the forms.

    Attributes:
        displacement: unknown field, three components a node.
        last_iterate: field that the tangent reads the previous iterate from; None if it needs none.
        residual_form: compiled linear form.
        tangent_form: compiled bilinear form.
        symmetric: whether the tangent is symmetric: LDL^T then, LU if not.
        supports: homogeneous Dirichlet conditions; the reactions of their vertical dofs measure the load.
        length: length in m that increments are measured against.
    """

    displacement: Any
    last_iterate: Any
    residual_form: Any
    tangent_form: Any
    symmetric: bool
    supports: Supports
    length: float

    @property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off leaves unbalanced."""

    @property
    def coupling(self) -> Coupling | None:
        """Couplings of nodes beside the forms, None on all ranks if there are none."""


@dataclass(frozen=True)
class Outcome:
    """How a solve ended.

    Attributes:
        converged: whether the solution holds.
        iterations: Newton iterations.
        reason: in words, why it ended.
    """

    converged: bool
    iterations: int
    reason: str


REASONS = {
    PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "Newton's method did not converge",
    PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN: "the residual is not a number",
    PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the linear solver failed: singular tangent or not enough memory",
}


FLOOR_INCREMENT = 1e-3
OPTIONS = {
    "ncf_snes_linesearch_type": "basic",
    "ncf_mat_mumps_icntl_14": 60,  # per cent of spare workspace: pivoting of an indefinite tangent needs it
    "options_left": "no",  # no complaint where nothing was solved
}


class Newton:
    """SNES with full steps, a cap on the nodal increment, and MUMPS.

    The residual norm is no merit function here: fibres a million times stiffer than the fabric across its thickness
    rule it, and a line search on it stalls. So steps are full, scaled back only where a node would move more than
    ``increment_cap`` lengths.

    Args:
        system: what is solved.
        settings: tolerances and limits.
        phases: clock that assembly and linear solution are booked on.
    """

    def __init__(self, system: System, settings: Settings, phases: Phases) -> None:
        self.system, self.settings, self.phases = system, settings, phases
        self.comm = system.displacement.function_space.mesh.comm
        self.matrix = self._matrix()
        self.vector = fem_petsc.create_vector(system.residual_form)
        self.unknown = self.vector.duplicate()
        self.load = 0.0
        held = system.supports.dofs
        self._held = held[held < self.vector.getLocalSize()]
        self._free_pairs = self._unheld(held)
        self.floor = system.force_floor
        self.snes = self._snes()

    def solve(self) -> Outcome:
        """Solve from the system's present displacement, which is a solution only if the outcome converged."""
        system = self.system
        self.unknown.array[:] = system.displacement.x.array[: self.unknown.getLocalSize()]
        with self.phases("solve"):
            self.snes.solve(None, self.unknown)
        self._take(self.unknown)
        reason = self.snes.getConvergedReason()
        words = "converged" if reason > 0 else REASONS.get(reason, f"SNES stopped with reason {reason}")
        unbalanced = f"{words} ({self.snes.getFunctionNorm():.2g} N unbalanced)"
        return Outcome(reason > 0, self.snes.getIterationNumber(), unbalanced)

    def evaluate_residual(self) -> Floats:
        """Out-of-balance forces in N of all owned dofs at the present displacement, reactions included."""
        return self._assemble_residual(self.vector).array_r.copy()

    def _matrix(self) -> Any:
        pattern = compat.sparsity_pattern(self.system.tangent_form)
        if self.system.coupling is not None:
            for pair in self.system.coupling.nodes:
                pattern.insert(pair, pair)
        pattern.finalize()
        return compat.create_matrix(self.comm, pattern)

    def _unheld(self, held: Integers) -> NDArray[np.bool_]:
        """Which entries of each pair's block concern no held dof, shape (pairs, 6, 6)."""
        if self.system.coupling is None:
            return np.zeros((0, 6, 6), dtype=bool)
        dofs = (3 * self.system.coupling.nodes[:, :, None] + np.arange(3)).reshape(-1, 6)
        free = ~np.isin(dofs, held)
        return free[:, :, None] & free[:, None, :]

    def _snes(self) -> Any:
        snes = PETSc.SNES().create(self.comm)
        snes.setOptionsPrefix("ncf_")
        for name, value in OPTIONS.items():
            PETSc.Options()[name] = value
        snes.setType("newtonls")
        snes.setFunction(self._residual, self.vector)
        snes.setJacobian(self._tangent, self.matrix)
        snes.setConvergenceTest(self._test)
        snes.setLineSearchPreCheck(self._cap)
        snes.setTolerances(max_it=self.settings.max_iterations)
        snes.getKSP().setType("preonly")
        snes.getKSP().getPC().setType("cholesky" if self.system.symmetric else "lu")
        snes.getKSP().getPC().setFactorSolverType("mumps")
        snes.setFromOptions()
        return snes

    def _take(self, x: Any) -> None:
        x.ghostUpdate(INSERT, FORWARD)
        with x.localForm() as local:
            self.system.displacement.x.array[:] = local.array_r

    def _assemble_residual(self, b: Any) -> Any:
        system = self.system
        with b.localForm() as local:
            local.set(0.0)
        fem_petsc.assemble_vector(b, system.residual_form)
        if system.coupling is not None:
            with b.localForm() as local:
                np.add.at(local.array.reshape(-1, 3), system.coupling.nodes, system.coupling.residual())
        b.ghostUpdate(ADD, REVERSE)
        return b

    def _residual(self, snes: Any, x: Any, b: Any) -> None:
        del snes
        with self.phases("assembly"):
            self._take(x)
            self._assemble_residual(b)
            self.load = self.comm.allreduce(float(np.abs(b.array_r[self.system.supports.vertical_dofs]).sum()))
            b.array[self._held] = x.array_r[self._held]

    def _tangent(self, snes: Any, x: Any, A: Any, P: Any) -> None:
        del snes, A, P
        system = self.system
        with self.phases("assembly"):
            self._take(x)
            self.assemble_tangent()
            if system.last_iterate is not None:
                system.last_iterate.x.array[:] = system.displacement.x.array

    def assemble_tangent(self) -> Any:
        """Tangent in N/m at the present displacement, rows and columns of held dofs those of the unit matrix."""
        A, system = self.matrix, self.system
        A.zeroEntries()
        fem_petsc.assemble_matrix(A, system.tangent_form, bcs=system.supports.conditions)
        if system.coupling is not None:
            A.assemble(PETSc.Mat.AssemblyType.FLUSH)
            self._add_coupling(A, system.coupling)
        A.assemble()
        return A

    def _add_coupling(self, A: Any, coupling: Coupling) -> None:
        if len(coupling.nodes):
            blocks = coupling.tangent() * self._free_pairs
            A.setValuesBlockedLocalRCV(coupling.nodes, coupling.nodes, blocks, ADD)

    def _cap(self, x: Any, step: Any) -> None:
        del x
        largest = step.norm(PETSc.NormType.NORM_INFINITY)
        cap = self.settings.increment_cap * self.system.length
        if largest > cap:
            step.scale(cap / largest)

    def _test(self, snes: Any, iteration: int, norms: tuple[float, float, float]) -> Any:
        reasons = PETSc.SNES.ConvergedReason
        residual = norms[2]
        if not np.isfinite(residual):
            return reasons.DIVERGED_FNORM_NAN
        if iteration and self._small(residual, snes.getSolutionUpdate().norm(PETSc.NormType.NORM_INFINITY)):
            return reasons.CONVERGED_FNORM_ABS
        return reasons.DIVERGED_MAX_IT if iteration >= self.settings.max_iterations else reasons.ITERATING

    def _small(self, residual: float, increment: float) -> bool:
        """Whether forces balance and the last increment (m) is small.

        Where round-off alone is above the force tolerance, the increment has to be smaller by as much as it takes for
        the next one, with quadratic convergence, to vanish in round-off too.
        """
        allowed = self.settings.increment_tolerance * self.system.length
        if residual <= self.settings.force_tolerance * self.load:
            return increment <= allowed
        return residual <= self.floor and increment <= FLOOR_INCREMENT * allowed


def petsc_version() -> str:
    """Version of PETSc."""
    return ".".join(str(number) for number in PETSc.Sys.getVersion())
