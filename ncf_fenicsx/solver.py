"""One nonlinear solve by Newton's method: the only room that knows PETSc."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
Integers = NDArray[np.int64]
ADD, INSERT = PETSc.InsertMode.ADD, PETSc.InsertMode.INSERT
FORWARD, REVERSE = PETSc.ScatterMode.FORWARD, PETSc.ScatterMode.REVERSE


class Contacts(Protocol):
    """Forces between nodes, beside the compiled forms, and unknown heights of tools.

    Attributes:
        controls: equations of tools whose height is an unknown at some time.
    """

    @property
    def controls(self) -> Sequence[Control]: ...  # noqa: D102

    def refresh(self) -> None:
        """Follow the present displacement."""

    def release(self) -> None:
        """Keep nothing in contact any more that the first linear solve of a step did."""

    def residual(self) -> Iterator[tuple[Integers, Floats]]:
        """Global node numbers, and residuals in N of shape (nodes, 3)."""

    def tangent(self) -> Iterator[tuple[Integers, Integers, Floats]]:
        """Global node numbers of rows (n, a) and columns (n, b), and blocks in N/m of shape (n, 3 a, 3 b)."""

    def links(self) -> Iterator[tuple[Integers, Integers]]:
        """Global numbers of the nodes that the tangent couples, rows (n, a) and columns (n, b)."""


class Control(Protocol):
    """Equation of one tool's height."""

    @property
    def active(self) -> bool:
        """Whether the height is an unknown of the step."""

    @property
    def target(self) -> float | None:
        """Force in N that the tool has to carry; None if its height is given."""

    def excess(self) -> float:
        """Force on the tool above the target in N."""

    def column(self) -> Floats:
        """Derivative of the residual by the height in N/m, of the owned dofs."""

    def row(self) -> Floats:
        """Derivative of the force by the displacement in N/m, of the owned dofs."""

    def stiffness(self) -> float:
        """Derivative of the force by the height in N/m."""

    def shift(self, height: float) -> None:
        """Raise the tool by a height in m."""


class System(Protocol):
    """What is solved: compiled forms, constraints, and contacts beside the forms.

    Attributes:
        displacement: unknown field, three components a node.
        last_iterate: field that the tangent reads the previous iterate from; None if it needs none.
        residual_form: compiled linear form.
        tangent_form: compiled bilinear form.
        symmetric: whether the tangent is symmetric: LDL^T then, LU if not.
        supports: homogeneous Dirichlet conditions.
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
    def increment_cap(self) -> float:
        """Largest increment in m of a component of the displacement in one of Newton's steps."""

    @property
    def contacts(self) -> Contacts:
        """Forces between nodes beside the forms, and controls."""

    def load(self, residual: Floats) -> float:
        """Forces in N that carry the body, given the residual in N of the owned dofs."""


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

    def followed_by(self, later: Outcome) -> Outcome:
        """This solve and one after it, as one."""
        return Outcome(later.converged, self.iterations + later.iterations, later.reason)


REASONS = {
    PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "Newton's method did not converge",
    PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN: "the residual is not a number",
    PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the linear solver failed: singular tangent or not enough memory",
}


FLOOR_INCREMENT = 1e-3
PATTERN_AT_ONCE = 100_000
OPTIONS = {
    "ncf_snes_linesearch_type": "basic",
    "ncf_mat_mumps_icntl_14": 60,  # per cent of spare workspace: pivoting of an indefinite tangent needs it
    "options_left": "no",  # no complaint where nothing was solved
}


class Newton:
    """SNES with full steps, a cap on the nodal increment, and MUMPS.

    The residual norm is no merit function here: fibres a million times stiffer than the fabric across its thickness
    rule it, and a line search on it stalls. So steps are full, scaled back only where a node would move more than
    a cap.

    Args:
        system: what is solved.
        settings: tolerances and limits.
        phases: clock that assembly and linear solution are booked on.
    """

    def __init__(self, system: System, settings: Settings, phases: Phases) -> None:
        self.system, self.settings, self.phases = system, settings, phases
        self.comm = system.displacement.function_space.mesh.comm
        self.vector = fem_petsc.create_vector(system.residual_form)
        self.unknown = self.vector.duplicate()
        self.load = 0.0
        held = system.supports.dofs
        self._held = held[held < self.vector.getLocalSize()]
        self._free = self._unheld()
        self._links: Integers = np.zeros(0, dtype=np.int64)
        self.floor = system.force_floor
        self.snes = self._snes()
        self.matrix: Any = None
        self._follow_links()

    def solve(self, patience: int = 1) -> Outcome:
        """Solve from the system's present displacement, which is a solution only if the outcome converged.

        Args:
            patience: factor on the number of iterations after which to give up.
        """
        system, self._most = self.system, patience * self.settings.max_iterations
        self._follow_links()
        self.unknown.array[:] = system.displacement.x.array[: self.unknown.getLocalSize()]
        with self.phases("solve"):
            reason = self._run()
        self._take(self.unknown)
        words = "converged" if reason > 0 else REASONS.get(reason, f"SNES stopped with reason {reason}")
        unbalanced = f"{words} ({self.snes.getFunctionNorm():.2g} N unbalanced)"
        return Outcome(reason > 0, self.snes.getIterationNumber(), unbalanced)

    def _run(self) -> int:
        """Run SNES; its reason."""
        self.snes.solve(None, self.unknown)
        reason: int = self.snes.getConvergedReason()
        if reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE:
            self.snes.getKSP().reset()  # else PETSc does not factorise again after a failure
        return reason

    def evaluate_residual(self) -> Floats:
        """Out-of-balance forces in N of all owned dofs at the present displacement, reactions included."""
        return self._assemble_residual(self.vector).array_r.copy()

    def _follow_links(self) -> None:
        """A new matrix where contact couples nodes that its pattern does not: entries are added, never dropped."""
        nodes = self.system.displacement.function_space.dofmap.index_map
        pairs = [np.zeros(0, dtype=np.int64)]
        for rows, columns in self.system.contacts.links():
            pairs.append((rows[:, :, None] * nodes.size_global + columns[:, None, :]).ravel())
        links = np.union1d(self._links, np.concatenate(pairs))
        grown = self.comm.allreduce(len(links) > len(self._links))
        if self.matrix is not None and not grown:
            return
        self._links = links
        if self.matrix is not None:
            self.snes.getKSP().reset()  # the factors are those of the old pattern
            self.matrix.destroy()
        self._unfilled = np.stack(np.divmod(links, nodes.size_global), axis=1)
        self.matrix = compat.create_matrix(self.system.displacement.function_space, self._unfilled)
        self.snes.setJacobian(self._tangent, self.matrix)

    def _unheld(self) -> NDArray[np.bool_]:
        """Which dofs of the whole mesh are not held, by global node number, shape (nodes, 3); empty without links."""
        index_map = self.system.displacement.function_space.dofmap.index_map
        first = 3 * index_map.local_range[0]
        free = np.ones(3 * index_map.size_global, dtype=bool)
        free[np.concatenate(self.comm.allgather(first + self._held.astype(np.int64)))] = False
        return free.reshape(-1, 3)

    def _snes(self) -> Any:
        snes = PETSc.SNES().create(self.comm)
        snes.setOptionsPrefix("ncf_")
        for name, value in OPTIONS.items():
            PETSc.Options()[name] = value
        snes.setType("newtonls")
        snes.setFunction(self._residual, self.vector)
        snes.setConvergenceTest(self._test)
        snes.setLineSearchPreCheck(self._before_step)
        snes.setTolerances(max_it=100_000)  # the convergence test knows when to give up
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
        system.contacts.refresh()
        fem_petsc.assemble_vector(b, system.residual_form)
        b.ghostUpdate(ADD, REVERSE)
        for nodes, values in system.contacts.residual():
            b.setValuesBlocked(nodes.astype(PETSc.IntType), values, ADD)
        b.assemble()
        return b

    def _residual(self, snes: Any, x: Any, b: Any) -> None:
        del snes
        with self.phases("assembly"):
            self._take(x)
            self._assemble_residual(b)
            self.load = self.system.load(b.array_r)
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
        system.contacts.refresh()
        fem_petsc.assemble_matrix(A, system.tangent_form, bcs=system.supports.conditions)
        A.assemble(PETSc.Mat.AssemblyType.FLUSH)
        self._fill_pattern()
        for rows, columns, blocks in system.contacts.tangent():
            free = [self._free[nodes].reshape(len(nodes), -1) for nodes in (rows, columns)]
            unheld = blocks * free[0][:, :, None] * free[1][:, None, :]
            A.setValuesBlockedRCV(rows.astype(PETSc.IntType), columns.astype(PETSc.IntType), unheld, ADD)
        A.assemble()
        return A

    def _fill_pattern(self) -> None:
        """Set all links once: PETSc drops entries from a new matrix that nothing is added to."""
        for start in range(0, len(self._unfilled), PATTERN_AT_ONCE):
            links = self._unfilled[start : start + PATTERN_AT_ONCE].astype(PETSc.IntType)
            self.matrix.setValuesBlockedRCV(links[:, :1], links[:, 1:], np.zeros((len(links), 3, 3)), ADD)
        self._unfilled = self._unfilled[:0]

    def _before_step(self, x: Any, step: Any) -> None:
        """Correct Newton's step for the unknown heights of tools, scale it back to the cap, and move those tools."""
        del x
        self.system.contacts.release()
        controls = [control for control in self.system.contacts.controls if control.active]
        heights = self._border(step, controls)
        largest = max(step.norm(PETSc.NormType.NORM_INFINITY), np.abs(heights).max(initial=0.0))
        scale = min(1.0, self.system.increment_cap / largest) if largest else 1.0
        step.scale(scale)
        for control, height in zip(controls, heights, strict=True):
            control.shift(-scale * height)

    def _border(self, step: Any, controls: list[Control]) -> Floats:
        """Heights h in m of the step that solves both K u + C h = r and R u + S h = e; u replaces K^-1 r in ``step``.

        K is the tangent, whose factors are at hand, and C, R, S are the columns, rows and stiffnesses of the controls.
        """
        if not controls:
            return np.zeros(0)
        columns, rows = [], []
        for control in controls:
            column, row = step.duplicate(), step.duplicate()
            column.array[:], row.array[:] = control.column(), control.row()
            column.array[self._held] = row.array[self._held] = 0.0
            solved = step.duplicate()
            self.snes.getKSP().solve(column, solved)
            columns.append(solved)
            rows.append(row)
        schur = -np.array([[row.dot(column) for column in columns] for row in rows])
        schur += np.diag([control.stiffness() for control in controls])
        excess = np.array([control.excess() - row.dot(step) for control, row in zip(controls, rows, strict=True)])
        heights: Floats = np.linalg.lstsq(schur, excess, rcond=None)[0]
        for column, height in zip(columns, heights, strict=True):
            step.axpy(-height, column)
        return heights

    def _test(self, snes: Any, iteration: int, norms: tuple[float, float, float]) -> Any:
        reasons = PETSc.SNES.ConvergedReason
        residual = norms[2]
        if not np.isfinite(residual):
            return reasons.DIVERGED_FNORM_NAN
        if iteration and self._small(residual, snes.getSolutionUpdate().norm(PETSc.NormType.NORM_INFINITY)):
            return reasons.CONVERGED_FNORM_ABS
        return reasons.DIVERGED_MAX_IT if iteration >= self._most else reasons.ITERATING

    def _small(self, residual: float, increment: float) -> bool:
        """Whether forces balance, those under control included, and the last increment (m) is small.

        Where round-off alone is above the force tolerance, the increment has to be smaller by as much as it takes for
        the next one, with quadratic convergence, to vanish in round-off too.
        """
        allowed = self.settings.increment_tolerance * self.system.length
        for control in self.system.contacts.controls:
            if control.target is not None and abs(control.excess()) > self.settings.force_tolerance * control.target:
                return False
        if residual <= self.settings.force_tolerance * self.load:
            return increment <= allowed
        return residual <= self.floor and increment <= FLOOR_INCREMENT * allowed


def petsc_version() -> str:
    """Version of PETSc."""
    return ".".join(str(number) for number in PETSc.Sys.getVersion())
