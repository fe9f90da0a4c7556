"""Surrogates of a result, fitted to a few runs: polynomial chaos or Kriging, each with its own error, by OpenTURNS.

A surrogate is fitted again without each tenth of the runs. What it then says of that tenth gives its error, and how far
its indices move gives their confidence (jackknife over tenths).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import openturns as ot
from numpy.typing import NDArray
from scipy.stats import norm

from ncf_fenicsx.sweeps import sobol
from ncf_fenicsx.sweeps.estimates import CONFIDENCE, Estimate, Estimates
from ncf_fenicsx.sweeps.germs import Germ, distribution

Floats = NDArray[np.float64]
ot.Log.Show(ot.Log.NONE)  # its optimiser tells of each bound that it moves
FOLDS = 10
HIGHEST_DEGREE = 15
TERMS_PER_RUN = 2
"""Terms that a chaos may choose from, over the number of runs: least-angle regression takes few of them."""
SAMPLE = 1024
"""Rows of each of two samples that the indices of Kriging are computed with."""


@dataclass(frozen=True)
class Surrogate:
    """A fitted surrogate.

    Attributes:
        predict: values at points of shape (points, germs).
        indices: first and total index of each input, shape (germs, 2).
        unexplained: share of the variance that it leaves where it was not fitted, by cross-validation (1 - Q2).
        deviations: standard errors of the indices.
    """

    predict: Callable[[Floats], Floats]
    indices: Floats
    unexplained: float
    deviations: Floats

    @property
    def estimates(self) -> list[Estimates]:
        """First and total index of each input with confidence."""
        half = float(norm.ppf((1 + CONFIDENCE) / 2)) * self.deviations
        ends: Any = np.stack([self.indices, self.indices - half, self.indices + half], axis=-1).tolist()
        return [{"first": Estimate(*first), "total": Estimate(*total)} for first, total in ends]


def fit(kind: str, germs: Sequence[Germ], points: Floats, values: Floats) -> Surrogate:
    """Fit a surrogate.

    Args:
        kind: ``chaos`` or ``kriging``.
        germs: the inputs' independent variables.
        points: shape (runs, germs).
        values: of the result, shape (runs,), all of them numbers.
    """
    fitted = KINDS[kind]
    predict, indices = fitted(germs, points, values)
    fold = np.arange(len(values)) % FOLDS
    missed, moved = np.empty(len(values)), []
    for number in range(FOLDS):
        out = fold == number
        without, indices_without = fitted(germs, points[~out], values[~out])
        missed[out] = values[out] - without(points[out])
        moved.append(indices_without)
    spread = np.array(moved) - np.mean(moved, axis=0)
    deviations = np.sqrt((FOLDS - 1) / FOLDS * (spread**2).sum(axis=0))
    return Surrogate(predict, indices, float((missed**2).mean() / values.var()), deviations)


def _chaos(germs: Sequence[Germ], points: Floats, values: Floats) -> tuple[Callable[[Floats], Floats], Floats]:
    """Sparse polynomial chaos (Blatman and Sudret 2011): terms by least-angle regression and leave-one-out error."""
    joint = distribution(germs)
    order = ot.LinearEnumerateFunction(len(germs))
    factories = [ot.StandardDistributionPolynomialFactory(joint.getMarginal(one)) for one in range(len(germs))]
    basis = ot.OrthogonalProductPolynomialFactory(factories, order)
    fitting = [
        degree
        for degree in range(1, HIGHEST_DEGREE + 1)
        if order.getStrataCumulatedCardinal(degree) <= TERMS_PER_RUN * len(values)
    ]
    terms = order.getStrataCumulatedCardinal(max(fitting, default=1))
    choice = ot.LeastSquaresMetaModelSelectionFactory(ot.LARS(), ot.CorrectedLeaveOneOut())
    algorithm = ot.FunctionalChaosAlgorithm(
        ot.Sample(points),
        ot.Sample(values[:, None]),
        joint,
        ot.FixedStrategy(basis, terms),
        ot.LeastSquaresStrategy(choice),
    )
    algorithm.run()
    result = algorithm.getResult()
    shares = ot.FunctionalChaosSobolIndices(result)
    indices = [[shares.getSobolIndex(one), shares.getSobolTotalIndex(one)] for one in range(len(germs))]
    return _predictor(result.getMetaModel()), np.array(indices)


def _kriging(germs: Sequence[Germ], points: Floats, values: Floats) -> tuple[Callable[[Floats], Floats], Floats]:
    """Kriging with a constant trend and Matérn's covariance of smoothness 5/2; its indices by Saltelli's estimators."""
    size = len(germs)
    covariance = ot.MaternModel([0.5] * size, 2.5)
    trend = ot.ConstantBasisFactory(size).build()
    algorithm = ot.KrigingAlgorithm(ot.Sample(points), ot.Sample(values[:, None]), covariance, trend)
    algorithm.setOptimizationBounds(ot.Interval([0.02] * size, [20.0] * size))
    algorithm.run()
    predict = _predictor(algorithm.getResult().getMetaModel())
    where = sobol.points(germs, SAMPLE, 1)
    rows = sobol.indices(where, predict(where))
    return predict, np.array([[row["first"].value, row["total"].value] for row in rows])


def _predictor(model: Any) -> Callable[[Floats], Floats]:
    return lambda points: np.array(model(ot.Sample(points)))[:, 0]


KINDS = {"chaos": _chaos, "kriging": _kriging}
