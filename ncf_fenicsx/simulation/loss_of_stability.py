"""What a run does where its stack loses stability: says so, writes the mode, leaves the branch."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.time_step import Outcome
from ncf_fenicsx.output.measures import Measures
from ncf_fenicsx.output.results_folder import Results
from ncf_fenicsx.simulation.interruption import Interruption
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.simulation.step import StabilisedStep
from ncf_fenicsx.solver import Newton

Floats = NDArray[np.float64]


class LossOfStability:
    """Watches the accepted steps of a run.

    Args:
        newton: finds the mode.
        measures: of the run.
        results: where the mode is written.
        progress: where it is said.
        steps: of the run, with its viscosity.
        interruption: of the run; told where a viscosity has had too much of the work.

    Attributes:
        lost: when stability was lost first, with the pivots and, if the scene asks for the mode, its eigenvalue (N/m)
            and wavelength (m); None before.
        stabilised_from: time in s from which there has been a viscosity; None before.
    """

    def __init__(
        self,
        newton: Newton,
        measures: Measures,
        results: Results,
        progress: ProgressBar,
        steps: StabilisedStep,
        interruption: Interruption,
    ) -> None:
        self.newton, self.measures, self.results, self.progress = newton, measures, results, progress
        self.problem, self.steps, self.stabilisation = measures.problem, steps, steps.stabilisation
        self.interruption = interruption
        self.lost: dict[str, float] | None = None
        self.stabilised_from: float | None = None
        self._mode: Floats | None = None

    def watch(self, time: float, outcome: Outcome, viscous_share: float) -> None:
        """Look at a step that ends at a time (s), before its commit; its viscosity has had a share of the work."""
        scene = self.problem.scene
        if viscous_share > scene.solver.viscous_share:
            self.interruption.request = (
                f"the viscosity that stabilises the stack has had {viscous_share:.2g} of the tools' work: "
                "this is no solution of the laws"
            )
        if self.lost is None and outcome.negative_pivots:
            self.lost = {"time": time, "negative_pivots": outcome.negative_pivots}
            self.stabilisation.stability_lost = self.newton.unstable = True
            self.progress.caution(f"stability is lost at {time:.6g} s ({outcome.negative_pivots} negative pivots)")
            if scene.output.critical_mode or scene.solver.perturbation is not None:
                self._find_mode(self.lost)
        if self.stabilised_from is None and self.stabilisation.value:
            self.stabilised_from = time
            self.progress.caution(f"a viscosity stabilises the stack from {time:.6g} s on: see viscous_share")

    def _find_mode(self, found: dict[str, float]) -> None:
        pair = self.newton.critical_mode()
        if pair is not None:
            value, self._mode = pair
            self.results.mode(self._mode)
            found |= {"eigenvalue": value, "wavelength": self.measures.contacts.waves.wavelength(self._mode)}

    def leave_branch(self) -> None:
        """After the commit: push the stack along the mode, if it has just been found and the scene asks for that."""
        size, mode = self.problem.scene.solver.perturbation, self._mode
        self._mode = None
        if size is not None and mode is not None:
            self.steps.time_step.push(size * mode.ravel())
            self.stabilisation.start()

    def record(self) -> dict[str, Any]:
        """What the record of the run, and a checkpoint, say of it."""
        return {"loss_of_stability": self.lost, "stabilised_from": self.stabilised_from}

    def recall(self, saved: dict[str, Any]) -> None:
        """Go on from a checkpoint."""
        self.lost, self.stabilised_from = saved["loss_of_stability"], saved["stabilised_from"]
        self.stabilisation.stability_lost = self.newton.unstable = self.lost is not None
