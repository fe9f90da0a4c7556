"""Sobol's indices: the share of a result's variance by an input alone (first), and by all it takes part in (total).

Estimators of Saltelli (2010) at points of Sobol's sequence, with intervals of their asymptotic normal law (OpenTURNS).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import openturns as ot
from numpy.typing import NDArray

from ncf_fenicsx.sweeps.estimates import CONFIDENCE, Estimate, Estimates
from ncf_fenicsx.sweeps.germs import Germ, distribution

Floats = NDArray[np.float64]


def points(germs: Sequence[Germ], count: int, seed: int) -> Floats:
    """Points of the estimators, shape (count (germs + 2), germs).

    Args:
        germs: the inputs' independent variables.
        count: rows of each of two independent samples.
        seed: the same one gives the same points.
    """
    ot.RandomGenerator.SetSeed(seed)
    sequence = ot.LowDiscrepancyExperiment(ot.SobolSequence(), distribution(germs), count)
    sequence.setRandomize(True)
    return np.array(ot.SobolIndicesExperiment(sequence, False).generate())


def indices(where: Floats, values: Floats) -> list[Estimates]:
    """First and total index of each input.

    Args:
        where: points of `points`.
        values: the result there, all of them numbers.
    """
    count = len(where) // (where.shape[1] + 2)
    algorithm = ot.SaltelliSensitivityAlgorithm(ot.Sample(where), ot.Sample(values[:, None] - values.mean()), count)
    algorithm.setUseAsymptoticDistribution(True)
    algorithm.setConfidenceLevel(CONFIDENCE)
    first, total = algorithm.getFirstOrderIndices(), algorithm.getTotalOrderIndices()
    around_first, around_total = algorithm.getFirstOrderIndicesInterval(), algorithm.getTotalOrderIndicesInterval()
    return [
        {
            "first": Estimate(first[one], around_first.getLowerBound()[one], around_first.getUpperBound()[one]),
            "total": Estimate(total[one], around_total.getLowerBound()[one], around_total.getUpperBound()[one]),
        }
        for one in range(where.shape[1])
    ]
