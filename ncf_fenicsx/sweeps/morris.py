"""Morris's screening: how much one step of an input moves a result, at many places of the ranges (Morris 1991).

On a grid of four values of each input, a trajectory goes from a point on to others, one input by two thirds of its
range at a time. The change of the result over that step of the range is an elementary effect.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as students

from ncf_fenicsx.sweeps.estimates import CONFIDENCE, Estimate, Estimates

Floats = NDArray[np.float64]
LEVELS = 4
STEP = LEVELS / (2 * (LEVELS - 1))


def trajectories(inputs: int, count: int, seed: int) -> Floats:
    """Points of trajectories as shares of the ranges, shape (count (inputs + 1), inputs).

    Args:
        inputs: number of inputs.
        count: of trajectories.
        seed: the same one gives the same points.
    """
    random, points = np.random.default_rng(seed), []
    for _ in range(count):
        ups = random.integers(0, 2, inputs).astype(bool)
        lower = random.integers(0, LEVELS // 2, inputs) / (LEVELS - 1)
        point = np.where(ups, lower, lower + STEP)
        points.append(point)
        for one in random.permutation(inputs):
            point = point.copy()
            point[one] += STEP if ups[one] else -STEP
            points.append(point)
    return np.array(points)


def elementary_effects(shares: Floats, values: Floats) -> list[Floats]:
    """Elementary effects of each input, in the result's unit over the whole range.

    Args:
        shares: points of `trajectories`.
        values: the result there; a step with a NaN at one end has none.
    """
    inputs = shares.shape[1]
    steps, changes = (np.diff(table.reshape(-1, inputs + 1, *table.shape[1:]), axis=1) for table in (shares, values))
    steps, changes = steps.reshape(-1, inputs), changes.ravel()
    moved = np.abs(steps).argmax(axis=1)
    slopes = changes / steps[np.arange(len(steps)), moved]
    return [slopes[(moved == one) & np.isfinite(slopes)] for one in range(inputs)]


def screened(shares: Floats, values: Floats) -> list[Estimates]:
    """For each input the mean of its effects, the mean of their sizes, and their standard deviation.

    Where the deviation is none, the input acts alone and in a straight line. Confidence is that of means of independent
    trajectories, by Student's distribution.
    """
    return [
        {"mean size": _mean(np.abs(one)), "mean": _mean(one), "deviation": Estimate(float(one.std(ddof=1)))}
        for one in elementary_effects(shares, values)
    ]


def _mean(effects: Floats) -> Estimate:
    count = len(effects)
    half = float(students.ppf((1 + CONFIDENCE) / 2, count - 1) * effects.std(ddof=1) / np.sqrt(count))
    mean = float(effects.mean())
    return Estimate(mean, mean - half, mean + half)
