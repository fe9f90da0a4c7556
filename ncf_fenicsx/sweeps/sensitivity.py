"""Sensitivity of a scene's results to its inputs: screening, Sobol's indices, directly or through a surrogate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import ResultError
from ncf_fenicsx.sweeps import germs, morris, sobol, surrogate
from ncf_fenicsx.sweeps.campaign import Campaign
from ncf_fenicsx.sweeps.effects import shares_in_words
from ncf_fenicsx.sweeps.estimates import Estimates
from ncf_fenicsx.sweeps.findings import estimate_panels, write_findings
from ncf_fenicsx.sweeps.inputs import Input
from ncf_fenicsx.sweeps.outcomes import RESULTS, Measure
from ncf_fenicsx.sweeps.parquet import write_parquet
from ncf_fenicsx.sweeps.pictures import draw_estimates
from ncf_fenicsx.sweeps.plans import shared
from ncf_fenicsx.sweeps.samples import Samples
from ncf_fenicsx.sweeps.tables import write_estimates

Floats = NDArray[np.float64]
METHODS = ("morris", "sobol", "chaos", "kriging")
LEAST_RUNS = 2 * surrogate.FOLDS


@dataclass(frozen=True)
class Design:
    """Which points a method needs.

    Attributes:
        method: one of `METHODS`.
        shares: of the inputs' ranges, shape (runs, inputs).
    """

    method: str
    shares: Floats

    @classmethod
    def of(cls, method: str, inputs: int, runs: int, seed: int) -> Design:
        """A design with at most a number of runs.

        Raises:
            SceneError: no such method, or too few runs for it.
        """
        if method not in METHODS:
            raise SceneError(f"--method {method}: expected one of {', '.join(METHODS)}")
        least = {"morris": 2 * (inputs + 1), "sobol": 2 * (inputs + 2)}.get(method, LEAST_RUNS)
        if runs < least:
            raise SceneError(f"--runs {runs}: too few for {method} with {inputs} inputs; expected at least {least}")
        if method == "morris":
            return cls(method, morris.trajectories(inputs, runs // (inputs + 1), seed))
        if method == "sobol":
            return cls(method, sobol.points(["share"] * inputs, runs // (inputs + 2), seed))
        return cls(method, germs.latin_hypercube(["share"] * inputs, runs, seed))

    def indices(self, values: Floats) -> tuple[list[Estimates], float | None]:
        """What a method says of a result, one for each input; of a surrogate the share of the variance that it leaves.

        Args:
            values: of the result at the points, NaN where there is none.

        Raises:
            ResultError: too many have none.
        """
        there = np.isfinite(values)
        if self.method == "morris":
            return morris.screened(self.shares, values), None
        if self.method == "sobol":
            if not there.all():
                missing = f"{(~there).sum()} of {len(there)} runs have no result"
                raise ResultError(f"{missing}; Sobol's estimators need all: choose smaller ranges, or --method chaos")
            return sobol.indices(self.shares, values), None
        if there.sum() < LEAST_RUNS:
            raise ResultError(f"{there.sum()} runs have a result; a surrogate needs at least {LEAST_RUNS}")
        fitted = surrogate.fit(self.method, ["share"] * self.shares.shape[1], self.shares[there], values[there])
        return fitted.estimates, fitted.unexplained


def sensitivity(campaign: Campaign, inputs: list[Input], design: Design) -> str:
    """Run what is missing of a design; tables, bars and a sentence for each result.

    Raises:
        SceneError: the folder holds something else, or the scheduler does not answer.
        ResultError: too many runs have no result.
    """
    plan = shared(inputs, design.shares)
    campaign.run(plan)
    write_parquet(campaign.rows)
    headings = [measure.heading for measure in RESULTS]
    samples = Samples.read(campaign.rows, [column.heading for column in plan.columns], headings)
    points, lines = list(plan.points()), [samples.in_words]
    found: dict[Measure, list[Estimates]] = {}
    for measure in RESULTS:
        values = samples.at(points, measure.heading)
        if samples.varies(measure.heading):
            estimates, unexplained = design.indices(values)
            found[measure] = estimates
            lines.append(in_words(measure, inputs, estimates, unexplained))
    table = campaign.folder / f"{design.method}.csv"
    names = [one.name for one in inputs]
    write_estimates(table, [(measure, *pair) for measure in found for pair in zip(names, found[measure], strict=True)])
    draw_estimates(inputs, found, campaign.folder / f"{design.method}.png")
    told = write_findings(campaign.folder, lines, estimate_panels(inputs, found))
    return "\n".join([*lines, *told, f"rows, table, picture and page in {campaign.folder}"])


def in_words(
    measure: Measure, inputs: Sequence[Input], estimates: Sequence[Estimates], unexplained: float | None
) -> str:
    """What a method says of a result, as a sentence."""
    names = [one.name for one in inputs]
    if "first" in estimates[0]:
        words = shares_in_words(measure.words, dict(zip(names, (one["first"].value for one in estimates), strict=True)))
        if unexplained is not None:
            words += f"; the surrogate leaves {100 * unexplained:.2g} % of it unexplained"
        return words
    ranked = sorted(zip(names, estimates, strict=True), key=lambda pair: -pair[1]["mean size"].value)
    moves = ", ".join(f"{name} {one['mean size'].value:.3g} {measure.unit}".rstrip() for name, one in ranked)
    return f"over its whole range moves the {measure.words}, in the mean of sizes: {moves}"
