"""The laws that meet compaction tests: numbers, their errors and correlations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.calibration.free_parameters import named, unknowns, value_of, with_values, written
from ncf_fenicsx.calibration.histories import History, Laws
from ncf_fenicsx.calibration.least_squares import least_squares
from ncf_fenicsx.calibration.specimens import Compaction, Machine

Floats = NDArray[np.float64]
Weight = Literal["thickness", "pressure"]
MACHINE = {"machine.compliance": "m/N", "machine.slack": "m"}
LOWEST = 0.02
"""Share of a test's largest pressure below which a row is not fitted: there the specimen is not yet touched evenly."""


@dataclass(frozen=True)
class Fit:
    """Fitted laws.

    Attributes:
        laws: with the fitted numbers.
        machine: compliance and slack, given or fitted.
        names: of what was fitted.
        values: fitted, in SI.
        covariance: of the values, by White's estimator for residuals of unequal size.
        residuals: what was to be zero, relative.
        weight: what residuals are of.
        criterion: Akaike's, with the correction for few rows.
        untold: groups of names that the tests do not tell apart, with how many numbers of each group they tell.
        compared: criteria of other laws, less that of this one.
    """

    laws: Laws
    machine: Machine
    names: list[str]
    values: Floats
    covariance: Floats
    residuals: Floats
    weight: Weight
    criterion: float
    untold: dict[tuple[str, ...], int] = field(default_factory=dict)
    compared: dict[str, float] = field(default_factory=dict)

    @property
    def errors(self) -> Floats:
        """Standard errors."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlations(self) -> Floats:
        """Between the values, shape (names, names)."""
        errors = np.where(self.errors > 0, self.errors, 1.0)
        return np.asarray(self.covariance / np.outer(errors, errors))

    @property
    def scatter(self) -> float:
        """Root of the mean square residual, relative."""
        return float(np.sqrt(np.mean(self.residuals**2)))


def fit_compaction(
    tests: list[Compaction], laws: Laws, names: list[str], machine: Machine, fitted: list[str], weight: Weight
) -> Fit:
    """Laws whose numbers make them meet the tests.

    Args:
        tests: at one or more speeds.
        laws: by family, with the numbers to begin from.
        names: what of the laws is free.
        machine: compliance and slack.
        fitted: those of the two that are free too.
        weight: residuals are those of thickness at given pressure, or of pressure at given thickness.

    Raises:
        SceneError: no fit was found.
    """
    free = unknowns(laws, names)
    for name in fitted:
        free = free.with_another(name, getattr(machine, name.split(".")[1]))
    scales = {written(name): 1e-3 if name.endswith("slack") else 1e-7 for name in fitted}
    kept = [test.pressure > LOWEST * test.pressure.max() for test in tests]

    def frame(numbers: Mapping[str, float]) -> Machine:
        found = {key: numbers.get(f"machine.{key}", getattr(machine, key)) for key in ("compliance", "slack")}
        return Machine(**found)

    def residuals(inner: Floats) -> Floats:
        numbers = free.named(inner)
        now, its = with_values(laws, numbers), frame(numbers)
        pairs = zip(tests, kept, strict=True)
        return np.concatenate([_off(History(now, test, its), test.pressure, rows, weight) for test, rows in pairs])

    found = least_squares(residuals, free.parameters(), scales).mapped(free.base, free.slopes)
    best = named(free.names, found.values)
    return Fit(
        laws=with_values(laws, best),
        machine=frame(best),
        names=free.names,
        values=found.values,
        covariance=found.covariance,
        residuals=found.residuals,
        weight=weight,
        criterion=akaike(found.residuals, len(free.names)),
        untold=found.untold(free.names),
    )


def _off(history: History, measured: Floats, rows: NDArray[np.bool_], weight: Weight) -> Floats:
    """What is to be zero at some rows of a test."""
    if weight == "thickness":
        return np.asarray(history.off_in_thickness(measured)[rows])
    return np.asarray(history.pressure[rows] / measured[rows] - 1)


def akaike(off: Floats, count: int) -> float:
    """Akaike's information criterion with the correction for few rows: smaller is better."""
    rows = len(off)
    return float(rows * np.log(np.mean(off**2)) + 2 * count + 2 * count * (count + 1) / max(rows - count - 1, 1))


def value_with_error(fit: Fit, name: str) -> tuple[float, float]:
    """A fitted number and its standard error; an error of 0 for one that was given."""
    if name in fit.names:
        place = fit.names.index(name)
        return float(fit.values[place]), float(fit.errors[place])
    return value_of(fit.laws, name), 0.0
