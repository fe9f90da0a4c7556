"""Least squares within bounds: values, their covariance, and which of them the residuals do not tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from lmfit import Parameters, minimize
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError

Floats = NDArray[np.float64]
BLIND = 1e-5
"""Change of the residuals over the largest one, below which a direction of the values is not told: differences of the
residuals are no better."""
UNTOLD = 1e6
"""Relative standard error that stands for one without bound."""
SHARE = 0.01
"""Share that a value has to have in such a direction to be one of those that are not told."""
FAR = 1e3
"""Residual where the laws have no value."""
STEP = 1e-5


@dataclass(frozen=True)
class Solution:
    """The best values.

    Attributes:
        values: in the order that they were asked for.
        covariance: of the values; White's estimator with the correction for rows that pull (HC3).
        residuals: left.
        blind: directions of the values along which the residuals do not change, shape (directions, values).
    """

    values: Floats
    covariance: Floats
    residuals: Floats
    blind: Floats

    def mapped(self, base: Floats, slopes: Floats) -> Solution:
        """That of base + slopes @ values."""
        covariance = slopes @ self.covariance @ slopes.T
        return Solution(base + slopes @ self.values, covariance, self.residuals, self.blind @ slopes.T)

    @property
    def errors(self) -> Floats:
        """Standard errors."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def untold(self, names: Sequence[str]) -> dict[tuple[str, ...], int]:
        """Groups of names that only change the residuals together, with how many numbers of each group are told."""
        shares = np.abs(self.blind) / np.maximum(np.abs(self.values), np.finfo(float).tiny)
        groups: list[set[int]] = []
        for row in shares:
            found = {int(place) for place in np.flatnonzero(row > SHARE * row.max())}
            apart = [group for group in groups if not group & found]
            groups = [*apart, found.union(*(group for group in groups if group & found))]
        counts = {tuple(sorted(group)): sum(1 for row in shares if int(row.argmax()) in group) for group in groups}
        return {tuple(names[n] for n in group): len(group) - count for group, count in counts.items()}


def least_squares(
    residuals: Callable[[Floats], Floats], begin: Parameters, scales: dict[str, float] | None = None
) -> Solution:
    """The values that make the sum of the squares of the residuals least.

    Residuals need not be of one size: the covariance takes each for what it is. Directions of the values that change
    no residual have an error of `UNTOLD` times the value, and a value that changes none stays as it begins.

    Args:
        residuals: of values, in the order of ``begin``.
        begin: parameters of lmfit with bounds.
        scales: sizes of values that begin at 0, where a relative step would be none.

    Raises:
        SceneError: the residuals are not finite, or are no more than the values.
    """
    sizes = np.array([(scales or {}).get(name) or abs(part.value) or 1.0 for name, part in begin.items()])
    scaled = Parameters()
    for size, (name, part) in zip(sizes, begin.items(), strict=True):
        scaled.add(name, value=part.value / size, min=part.min / size, max=part.max / size)

    def of(values: Floats) -> Floats:
        off = residuals(np.asarray(values) * sizes)
        return np.asarray(np.where(np.isfinite(off), off, FAR))

    def of_parameters(trial: Parameters) -> Floats:
        return of(np.array([part.value for part in trial.values()]))

    with np.errstate(invalid="ignore"):  # lmfit's own errors, which have no value where numbers are not told
        found = minimize(of_parameters, scaled, method="least_squares", calc_covar=False)
    best = np.array([part.value for part in found.params.values()])
    off = of(best)
    if len(off) <= len(best) or not np.all(np.abs(off) < FAR):
        raise SceneError("calibrate: the laws cannot be evaluated on these tests; expected other laws or more rows")
    slopes = _slopes(of, best, scaled)
    without = np.abs(slopes).max(axis=0) <= BLIND * np.abs(slopes).max()
    best[without] = np.array([part.value for part in scaled.values()])[without]
    covariance, blind = _covariance(slopes, off)
    return Solution(best * sizes, covariance * np.outer(sizes, sizes), off, blind * sizes)


def _slopes(of: Callable[[Floats], Floats], best: Floats, scaled: Parameters) -> Floats:
    """Derivatives of the residuals by differences within the bounds, shape (residuals, values)."""
    low, high = (np.array([getattr(part, end) for part in scaled.values()]) for end in ("min", "max"))
    columns = []
    for place, change in enumerate(STEP * np.eye(len(best))):
        behind, ahead = np.maximum(best - change, low), np.minimum(best + change, high)
        columns.append((of(ahead) - of(behind)) / (ahead - behind)[place])
    return np.stack(columns, axis=1)


def _covariance(slopes: Floats, off: Floats) -> tuple[Floats, Floats]:
    """HC3 in the directions that the residuals tell, `UNTOLD` squared in the others; and these.

    With the singular value decomposition slopes = U s V, the leverage of a row is that of U, and the estimator
    V^T s^-1 U^T diag((off / (1 - leverage))^2) U s^-1 V.
    """
    left, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    told = sizes > BLIND * sizes[0]
    left, along, blind = left[:, told], directions[told] / sizes[told, None], directions[~told]
    pull = np.einsum("ij,ij->i", left, left)
    spread = left * (off / np.maximum(1 - pull, 1e-6))[:, None]
    covariance = along.T @ (spread.T @ spread) @ along + UNTOLD**2 * blind.T @ blind
    return np.asarray(covariance), np.asarray(blind)
