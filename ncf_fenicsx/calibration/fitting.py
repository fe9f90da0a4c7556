"""Least squares on tests: parameters, their errors and correlations, and the choice among laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from lmfit import Parameters, minimize
from numpy.typing import NDArray

from ncf_fenicsx.calibration.free_parameters import parameters, value_of, with_values, written
from ncf_fenicsx.calibration.histories import History, Laws
from ncf_fenicsx.calibration.specimens import Compaction, Machine
from ncf_fenicsx.errors import SceneError

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
    """

    laws: Laws
    machine: Machine
    names: list[str]
    values: Floats
    covariance: Floats
    residuals: Floats
    weight: Weight
    criterion: float
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
    begin = parameters(laws, names)
    for name in fitted:
        begin.add(written(name), value=getattr(machine, name.split(".")[1]))
    scales = {written(name): 1e-3 if name.endswith("slack") else 1e-7 for name in fitted}
    kept = [test.pressure > LOWEST * test.pressure.max() for test in tests]

    def frame(named: Mapping[str, float]) -> Machine:
        found = {key: named.get(f"machine.{key}", getattr(machine, key)) for key in ("compliance", "slack")}
        return Machine(**found)

    def residuals(values: Floats) -> Floats:
        named = dict(zip([*names, *fitted], values, strict=True))
        now, its = with_values(laws, named), frame(named)
        pairs = zip(tests, kept, strict=True)
        return np.concatenate([_off(History(now, test, its), test.pressure, rows, weight) for test, rows in pairs])

    values, covariance, off = least_squares(residuals, begin, scales)
    named = dict(zip([*names, *fitted], values, strict=True))
    criterion = akaike(off, len(values))
    return Fit(with_values(laws, named), frame(named), [*names, *fitted], values, covariance, off, weight, criterion)


def _off(history: History, measured: Floats, rows: NDArray[np.bool_], weight: Weight) -> Floats:
    """What is to be zero at some rows of a test."""
    if weight == "thickness":
        return np.asarray(history.off_in_thickness(measured)[rows])
    return np.asarray(history.pressure[rows] / measured[rows] - 1)


def least_squares(
    residuals: Callable[[Floats], Floats], begin: Parameters, scales: dict[str, float] | None = None
) -> tuple[Floats, Floats, Floats]:
    """Values, their covariance, and the residuals left.

    The covariance is White's, with the correction for rows that pull (HC3): residuals need not be of one size.

    Args:
        residuals: of values, in the order of ``begin``.
        begin: parameters of lmfit with bounds.
        scales: sizes of values that begin at 0, where a relative step would be none.

    Raises:
        SceneError: the residuals are not finite, or do not tell the values apart.
    """
    sizes = np.array([(scales or {}).get(name) or abs(part.value) or 1.0 for name, part in begin.items()])
    scaled = Parameters()
    for size, (name, part) in zip(sizes, begin.items(), strict=True):
        scaled.add(name, value=part.value / size, min=part.min / size, max=part.max / size)

    def of(values: Floats) -> Floats:
        off = residuals(np.asarray(values) * sizes)
        return np.asarray(np.where(np.isfinite(off), off, 1e3))

    found = minimize(
        lambda trial: of(np.array([part.value for part in trial.values()])), scaled, method="least_squares"
    )
    best = np.array([part.value for part in found.params.values()])
    off = of(best)
    if len(off) <= len(best) or not np.all(np.abs(off) < 1e3):
        raise SceneError("calibrate: the laws cannot be evaluated on these tests; expected other laws or more rows")
    slopes = np.stack([(of(best + change) - of(best - change)) / 2e-5 for change in 1e-5 * np.eye(len(best))], axis=1)
    try:
        inverse = np.linalg.inv(slopes.T @ slopes)
    except np.linalg.LinAlgError as error:
        names = ", ".join(name.replace("__", ".") for name in begin)
        raise SceneError(f"calibrate: the tests do not tell {names} apart; expected --fix for some of them") from error
    pull = np.einsum("ij,jk,ik->i", slopes, inverse, slopes)
    spread = slopes * (off / np.maximum(1 - pull, 1e-6))[:, None]
    covariance = inverse @ (spread.T @ spread) @ inverse * np.outer(sizes, sizes)
    return best * sizes, np.asarray(covariance), off


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
