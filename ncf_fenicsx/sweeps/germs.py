"""Independent variables that inputs are made of: shares of a range, or standard normal numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import openturns as ot
from numpy.typing import NDArray
from scipy.stats import norm, qmc

Germ = Literal["share", "normal"]
"""Uniform between 0 and 1, or normal with mean 0 and deviation 1."""
Floats = NDArray[np.float64]


def distribution(germs: Sequence[Germ]) -> Any:
    """Their joint distribution for OpenTURNS."""
    return ot.JointDistribution([ot.Uniform(0.0, 1.0) if germ == "share" else ot.Normal() for germ in germs])


def latin_hypercube(germs: Sequence[Germ], count: int, seed: int) -> Floats:
    """Values with one in each of as many slices of equal probability as there are, shape (count, germs)."""
    shares = qmc.LatinHypercube(len(germs), rng=seed).random(count)
    normal = np.array([germ == "normal" for germ in germs])
    return np.where(normal, norm.ppf(shares), shares)
