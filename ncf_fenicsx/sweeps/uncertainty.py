"""How sure results are: distributions of inputs become distributions of results, directly or through a surrogate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import ResultError
from ncf_fenicsx.sweeps import germs, numerics, surrogate
from ncf_fenicsx.sweeps.campaign import Campaign
from ncf_fenicsx.sweeps.distributions import Uncertain
from ncf_fenicsx.sweeps.effects import shares_in_words
from ncf_fenicsx.sweeps.estimates import CONFIDENCE, Estimate, Estimates
from ncf_fenicsx.sweeps.findings import distribution_panels, write_findings
from ncf_fenicsx.sweeps.numerics import Refinement
from ncf_fenicsx.sweeps.outcomes import ERROR, RESULTS, Measure
from ncf_fenicsx.sweeps.parquet import write_parquet
from ncf_fenicsx.sweeps.pictures import draw_distributions
from ncf_fenicsx.sweeps.plans import Plan, join
from ncf_fenicsx.sweeps.samples import Samples
from ncf_fenicsx.sweeps.tables import write_estimates
from ncf_fenicsx.workers.rows import Point

Floats = NDArray[np.float64]
METHODS = ("direct", *surrogate.KINDS)
QUANTILES = {"5 %": 0.05, "median": 0.5, "95 %": 0.95}
DRAWN = 20_000
"""Values drawn from a surrogate."""
RESAMPLED = 500
"""Samples of the bootstrap."""


@dataclass(frozen=True)
class Draw:
    """Points drawn from the distributions of inputs.

    Attributes:
        inputs: with their distributions, independent of each other.
        method: one of `METHODS`.
        where: values of the independent variables, a Latin hypercube, shape (runs, germs).
        seed: of all that is drawn.
    """

    inputs: list[Uncertain]
    method: str
    where: Floats
    seed: int

    @classmethod
    def of(cls, inputs: list[Uncertain], method: str, runs: int, seed: int) -> Draw:
        """Draw points.

        Raises:
            SceneError: no such method, too few runs, or a key has two distributions.
        """
        keys = [column.key for one in inputs for column in one.columns]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise SceneError(f"--vary {twice}: has two distributions; expected one")
        if method not in METHODS:
            raise SceneError(f"--method {method}: expected one of {', '.join(METHODS)}")
        if runs < 2 * surrogate.FOLDS:
            raise SceneError(f"--runs {runs}: too few for a distribution; expected at least {2 * surrogate.FOLDS}")
        return cls(inputs, method, germs.latin_hypercube(germs_of(inputs), runs, seed), seed)

    @property
    def plan(self) -> Plan:
        """The points."""
        columns = tuple(column for one in self.inputs for column in one.columns)
        return Plan(columns, len(self.where), self._points)

    def _points(self) -> Iterator[Point]:
        ends = np.cumsum([0, *(len(one.germs) for one in self.inputs)])
        for row in self.where:
            values = [float(value) for value in row]
            yield join(one.at(values[ends[n] : ends[n + 1]]) for n, one in enumerate(self.inputs))

    @property
    def middle(self) -> Point:
        """The point in the middle of all inputs."""
        centre = {"normal": 0.0, "share": 0.5}
        return join(one.at([centre[germ] for germ in one.germs]) for one in self.inputs)

    def distribution(self, values: Floats) -> tuple[Floats, surrogate.Surrogate | None]:
        """Values of a result as they are distributed, and the surrogate that they are drawn from.

        Args:
            values: of the result at the points, NaN where there is none.

        Raises:
            ResultError: too few runs have one.
        """
        there = np.isfinite(values)
        if there.sum() < 2 * surrogate.FOLDS:
            raise ResultError(f"{there.sum()} runs have a result; expected at least {2 * surrogate.FOLDS}")
        if self.method == "direct":
            return values[there], None
        kinds = germs_of(self.inputs)
        fitted = surrogate.fit(self.method, kinds, self.where[there], values[there])
        return fitted.predict(germs.latin_hypercube(kinds, DRAWN, self.seed + 1)), fitted


def germs_of(inputs: Sequence[Uncertain]) -> list[germs.Germ]:
    """Independent variables of all inputs."""
    return [germ for one in inputs for germ in one.germs]


def described(values: Floats, seed: int) -> Estimates:
    """Mean, standard deviation and quantiles with intervals by the bootstrap (Efron 1979), as of independent values."""
    again = np.random.default_rng(seed).choice(values, (RESAMPLED, len(values)))
    probabilities = list(QUANTILES.values())
    of_all = [values.mean(), values.std(ddof=1), *np.quantile(values, probabilities)]
    of_each = [again.mean(axis=1), again.std(axis=1, ddof=1), *np.quantile(again, probabilities, axis=1)]
    ends = [np.quantile(each, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]) for each in of_each]
    return {
        name: Estimate(float(value), float(low), float(high))
        for name, value, (low, high) in zip(("mean", "deviation", *QUANTILES), of_all, ends, strict=True)
    }


def uncertainty(campaign: Campaign, draw: Draw, refinement: Refinement | None = None) -> str:
    """Run what is missing of the points; a table, distributions and a sentence for each result.

    Args:
        campaign: runs them.
        draw: the points.
        refinement: of the run in the middle of the inputs, for the numerical error of all; None to
            leave that out.

    Raises:
        SceneError: the folder holds something else, or the scheduler does not answer.
        ResultError: too many runs have no result.
    """
    plan = draw.plan
    campaign.run(plan)
    write_parquet(campaign.rows)
    headings = [measure.heading for measure in (*RESULTS, ERROR)]
    samples = Samples.read(campaign.rows, [column.heading for column in plan.columns], headings)
    points, lines = list(plan.points()), [samples.in_words]
    found: dict[Measure, Estimates] = {}
    drawn: dict[Measure, Floats] = {}
    for measure in RESULTS:
        if not samples.varies(measure.heading):
            continue
        values = samples.at(points, measure.heading)
        drawn[measure], fitted = draw.distribution(values)
        found[measure] = described(values[np.isfinite(values)] if fitted is None else drawn[measure], draw.seed)
        lines.append(in_words(measure, found[measure], draw.inputs, fitted))
    errors = samples.values[ERROR.heading]
    if np.isfinite(errors).any():
        lines.append(f"beside it, the mesh: the {ERROR.words} is {100 * np.nanmean(errors):.2g} % in the mean")
    if refinement is not None:
        lines += _numerics_in_words(campaign, draw, refinement, found)
    write_estimates(campaign.folder / "uncertainty.csv", [(measure, "", one) for measure, one in found.items()])
    draw_distributions(drawn, found, campaign.folder / "uncertainty.png")
    told = write_findings(campaign.folder, lines, distribution_panels(drawn, found, list(QUANTILES)))
    return "\n".join([*lines, *told, f"rows, table, picture and page in {campaign.folder}"])


def _numerics_in_words(
    campaign: Campaign, draw: Draw, refinement: Refinement, found: dict[Measure, Estimates]
) -> Iterator[str]:
    """The numerical error of each result beside the deviation that the inputs make."""
    of_middle, ending = numerics.numerics(campaign, draw.plan.columns, draw.middle, refinement)
    yield f"the run in the middle of the inputs, by levels: {ending}"
    for measure, one in of_middle.items():
        deviation = found[measure]["deviation"].value if measure in found else 0.0
        yield numerics.in_words(measure, one, deviation)


def in_words(
    measure: Measure, found: Estimates, inputs: Sequence[Uncertain], fitted: surrogate.Surrogate | None
) -> str:
    """A result's distribution as a sentence; with a surrogate of independent inputs also what it comes from."""
    low, middle, high = (f"{found[name].value:.4g}" for name in QUANTILES)
    unit = f" {measure.unit}" if measure.unit else ""
    words = f"the {measure.words} is {middle}{unit}, in 90 of 100 cases between {low} and {high}{unit}"
    if fitted is None:
        return words
    words += f"; the surrogate leaves {100 * fitted.unexplained:.2g} % of its variance unexplained"
    if all(len(one.columns) == 1 for one in inputs):
        shares = {one.name: float(first) for one, first in zip(inputs, fitted.indices[:, 0], strict=True)}
        words += f"; {shares_in_words(measure.words, shares)}"
    return words
