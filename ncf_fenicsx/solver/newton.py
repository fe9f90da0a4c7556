"""One nonlinear solve by Newton's method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from ncf_fenicsx.contact.force_control import ForceControl
from ncf_fenicsx.mechanics.time_step import USUAL, Effort, Outcome
from ncf_fenicsx.scene.settings import Solver as Settings
from ncf_fenicsx.solver import compat
from ncf_fenicsx.solver.assembly import Residual, TangentMatrix
from ncf_fenicsx.solver.bordering import border
from ncf_fenicsx.solver.convergence import Convergence
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.equations import System
from ncf_fenicsx.solver.factor_choice import linear_solver
from ncf_fenicsx.solver.modes import critical_mode
from ncf_fenicsx.solver.step_length import share_of_step, step_options
from ncf_fenicsx.solver.timing import Phases

Floats = NDArray[np.float64]
INSERT, FORWARD = PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD

REASONS = {
    compat.NO_NUMBER: "the residual is not a number",
    PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the linear solver failed: singular tangent or not enough memory",
}
KEEP_NONE = 1_000
"""Linear solves of a step for which contact is kept no more: a trust region judges steps before it could be let go."""
OPTIONS = {"options_left": "no"}
"""PETSc is not to complain of options where nothing was solved."""


class Newton:
    """SNES with full steps, a cap on the nodal increment, and MUMPS.

    The residual norm is no merit function here: fibres a million times stiffer than the fabric across its thickness
    rule it, and a line search on it stalls. So steps are full, scaled back only where a node would move more than a
    cap, unless the scene asks for a search or has friction.

    Args:
        system: what is solved.
        settings: tolerances and limits.
        phases: clock that assembly and linear solution are booked on.
        interrupted: in words, why to end at once, on all ranks; None to go on.

    Attributes:
        unstable: whether the run is known to have lost stability: negative pivots need no proof then.
    """

    def __init__(
        self,
        system: System,
        settings: Settings,
        phases: Phases,
        interrupted: Callable[[], str | None] = lambda: None,
    ) -> None:
        self.system, self.settings, self.phases, self._interrupted = system, settings, phases, interrupted
        self.convergence, self._stopped = Convergence(system, settings), ""
        self.residual = Residual(system)
        self.vector = self.residual.vector
        self.unknown = self.vector.duplicate()
        self.load, self.unstable = 0.0, False
        constrained = system.supports.dofs
        self._constrained = constrained[constrained < self.vector.getLocalSize()]
        self.linear = linear_solver(system, settings, self.vector, self._constrained)
        self.snes = self._snes()
        self.tangent = TangentMatrix(system, self._constrained)
        self.snes.setJacobian(self._tangent, self.tangent.matrix)

    def solve(self, effort: Effort = USUAL) -> Outcome:
        """Solve from the system's present displacement, which is a solution only if the outcome converged.

        Args:
            effort: that it may take.
        """
        system = self.system
        self._stopped = ""
        self.convergence.begin(effort)
        self.linear.begin()
        if self._in_trust_region:
            self.system.contacts.release(KEEP_NONE)
        with self.phases("forms"):
            self.tangent.follow_form()
        if self.tangent.follow_links():
            self.linear.forget()  # the factors are those of the old pattern
            self.snes.setJacobian(self._tangent, self.tangent.matrix)
        self.unknown.array[:] = system.displacement.x.array[: self.unknown.getLocalSize()]
        with self.phases("solve"):
            reason = self._run()
        self._take(self.unknown)
        iterations = self.snes.getIterationNumber() - self.convergence.polished
        with self.phases("solve"):
            pivots = self._negative_pivots(reason)
        PETSc.garbage_cleanup(self.vector.comm)  # several ranks free together, and only when told to
        words = "converged" if reason > 0 else self._failure(reason, pivots)
        wandered = self.convergence.wandered
        return Outcome(reason > 0, iterations, words, bool(self._stopped), pivots, wandered=wandered)

    def _failure(self, reason: int, pivots: int | None) -> str:
        """In words, why a solve failed, where forces are out of balance, and what its last tangent was like.

        Negative pivots on the way to no equilibrium are no proof that stability is lost: contact has them too.
        """
        if self._stopped:
            return self._stopped
        words = self.convergence.given_up or REASONS.get(reason, f"SNES stopped with reason {reason}")
        norm = self.snes.getFunctionNorm()
        if np.isfinite(norm):
            words += f" ({norm:.2g} N unbalanced, most at {self.convergence.position_of_largest(self.vector.array_r)})"
        return words + (f"; its last tangent had {pivots} negative pivots" if pivots else "")

    def _negative_pivots(self, reason: int) -> int | None:
        """Of the last factors, or a mode found without them; None with LU, or where they tell nothing."""
        unsolved = reason < 0 and not self.snes.getIterationNumber()
        failed = reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        if not self.system.symmetric or failed or unsolved:
            return None
        if reason < 0 and not self.linear.factors.exact:
            return None  # the search would go on from where there is no equilibrium
        if not self.linear.factorised:
            self.linear.factorise(self.tangent.assemble())
        count = self.linear.factors.count_negative(self.tangent.matrix)
        return self._proven(count) if count and reason > 0 else count

    def _proven(self, count: int) -> int:
        """Negative pivots at the solution where factors of an iterate before it have some, and a run has had none yet.

        Near a loss of stability a tangent that is a correction too old may have some where the solution has none.
        """
        if self.unstable:
            return count
        if self.linear.factorise(self._tangent_here()):
            self.linear.forget()
            return count
        return self.linear.factors.count_negative(self.tangent.matrix)

    def _tangent_here(self) -> Any:
        """The tangent at the present displacement, with nothing extrapolated."""
        if self.system.last_iterate is not None:
            self.system.last_iterate.x.array[:] = self.system.displacement.x.array
        return self.tangent.assemble()

    def factorise(self) -> None:
        """Factorise the tangent as last assembled as a whole, its order of elimination included, and forget that."""
        factors = DirectFactors(self.vector.comm, self.system.symmetric)
        factors.factorise(self.tangent.matrix)
        factors.forget()

    @property
    def pieces(self) -> dict[str, Callable[[], object]]:
        """What an iteration consists of, to be timed one by one."""
        linear, load, solution = self.linear, self.vector.duplicate(), self.vector.duplicate()
        load.set(1.0)
        return {
            "tangent": self.tangent.assemble,
            "residual": self.evaluate_residual,
            "factors": lambda: linear.factorise(self.tangent.matrix),
            "solution with factors": lambda: linear.factors.preconditioner.apply(load, solution),
        }

    def critical_mode(self) -> tuple[float, Floats] | None:
        """Lowest eigenvalue in N/m of the tangent at the present displacement, and its mode at this rank's local nodes.

        Returns:
            None if it is not found; else the mode has 1 as its largest component, and shape (nodes, 3).
        """
        found = critical_mode(self._tangent_here(), self._constrained)
        if found is None:
            return None
        value, vector = found
        field = self.unknown.duplicate()
        field.array[:] = vector.array_r / vector.norm(PETSc.NormType.NORM_INFINITY)
        field.ghostUpdate(INSERT, FORWARD)
        with field.localForm() as local:
            return value, local.array_r.reshape(-1, 3).copy()

    def _run(self) -> int:
        """Run SNES; its reason."""
        self.snes.solve(None, self.unknown)
        reason: int = self.snes.getConvergedReason()
        if reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE:
            self.linear.forget()  # else PETSc does not factorise again after a failure
        return reason

    def evaluate_residual(self) -> Floats:
        """Out-of-balance forces in N of all owned dofs at the present displacement, reactions included."""
        return self.residual.values()

    def _snes(self) -> Any:
        snes = PETSc.SNES().create(self.vector.comm)
        snes.setOptionsPrefix("ncf_")
        for name, value in (OPTIONS | step_options(self.settings.line_search)).items():
            PETSc.Options()[name] = value
        snes.setType("newtontr" if self._in_trust_region else "newtonls")
        if self._in_trust_region:
            snes.setTRTolerances(
                delta_min=0.0, delta_max=self.system.scales.increment_cap, delta_0=self.system.scales.increment_cap
            )
        snes.setFunction(self._residual, self.vector)
        snes.setConvergenceTest(self._test)
        snes.setLineSearchPreCheck(self._before_step)
        snes.setTolerances(max_it=100_000)  # the convergence test knows when to give up
        solver = snes.getKSP()
        solver.setOptionsPrefix("ncf_newton_")
        solver.setType("preonly")
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(self.linear)
        snes.setFromOptions()
        return snes

    @property
    def _in_trust_region(self) -> bool:
        return self.settings.line_search == "trust_region"

    def _take(self, x: Any) -> None:
        x.ghostUpdate(INSERT, FORWARD)
        with x.localForm() as local:
            self.system.displacement.x.array[:] = local.array_r

    def _residual(self, snes: Any, x: Any, b: Any) -> None:
        del snes
        with self.phases("assembly"):
            self._take(x)
            self.residual.assemble(b)
            self.load = self.system.scales.load(b.array_r)
            b.array[self._constrained] = x.array_r[self._constrained]

    def _tangent(self, snes: Any, x: Any, A: Any, P: Any) -> None:
        del snes, A, P
        system = self.system
        with self.phases("assembly"):
            self._take(x)
            self.tangent.assemble()
            self.linear.expect(self.convergence.nearly, exact=self._in_trust_region or bool(self._controls))
            if system.last_iterate is not None:
                system.last_iterate.x.array[:] = system.displacement.x.array

    @property
    def _controls(self) -> list[ForceControl]:
        """Equations of tools whose height is an unknown of the step."""
        return [control for control in self.system.contacts.controls if control.active]

    def _before_step(self, x: Any, step: Any) -> None:
        """Correct Newton's step for the unknown heights of tools, scale it back to the cap, and move those tools."""
        self.system.contacts.release(self.snes.getIterationNumber() + 1)
        controls, searches = self._controls, self.settings.searches
        heights = border(step, controls, self.snes.getKSP().solve, self._constrained)
        largest = max(step.norm(PETSc.NormType.NORM_INFINITY), np.abs(heights).max(initial=0.0))
        scale = 0.5 if self.convergence.cycling and not searches else 1.0
        scale = min(scale, self.system.scales.increment_cap / largest) if largest else 1.0
        step.scale(scale)
        heights *= scale
        if searches:
            share = self._share_by_work(x, step, heights)
            step.scale(share)
            heights *= share
        for control, height in zip(controls, heights, strict=True):
            control.shift(-height)

    def _share_by_work(self, x: Any, step: Any, heights: Floats) -> float:
        """Share of a correction -``step`` of ``x``, and of heights of tools (m), by the work along it."""
        forces, trial = self.vector.duplicate(), x.duplicate()

        def work(share: float) -> float:
            x.copy(trial)
            trial.axpy(-share, step)
            for control, height in zip(self._controls, heights, strict=True):
                control.shift(-share * height)
            self._residual(None, trial, forces)
            for control, height in zip(self._controls, heights, strict=True):
                control.shift(share * height)
            return float(forces.dot(step))

        share = share_of_step(self.vector.dot(step), work)
        self._take(x)
        return share

    def _test(self, snes: Any, iteration: int, norms: tuple[float, float, float]) -> Any:
        reasons, residual = PETSc.SNES.ConvergedReason, norms[2]
        if not np.isfinite(residual):
            return compat.NO_NUMBER
        interruption = self._interrupted()
        if interruption is not None:
            self._stopped = interruption
            return reasons.DIVERGED_INNER
        if not iteration:
            self.convergence.start(residual, self.load)
        else:
            self.convergence.follow(iteration, residual, self.load, snes.getSolutionUpdate().array_r)
        if self.convergence.converged:
            return reasons.CONVERGED_FNORM_ABS
        return reasons.DIVERGED_INNER if self.convergence.given_up else reasons.ITERATING
