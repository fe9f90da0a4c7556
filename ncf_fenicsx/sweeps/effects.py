"""Main effects: means of a result at the levels of an input, and the share of the variance that these means carry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.sweeps.inputs import Input, number_of
from ncf_fenicsx.sweeps.samples import Samples
from ncf_fenicsx.workers.rows import Point

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST_LEVELS = 12
"""Different values of an input up to which each is a level of its own."""
SLICES = 6
"""Slices with equally many runs that more values are put into."""


@dataclass(frozen=True)
class Effect:
    """Main effect of an input on a result.

    Attributes:
        name: of the input.
        labels: of its levels.
        places: of the levels on an axis: mean values of numbers, else 0, 1, 2.
        means: of the result at the levels.
        share: of the result's variance, 0 to 1.
    """

    name: str
    labels: list[str]
    places: Floats
    means: Floats
    share: float


def effect(one: Input, levels: list[Point], values: Floats) -> Effect:
    """Main effect of an input.

    The share is that of the sums of squares between levels and in all (eta squared). Where values are put into slices,
    as those of a Latin hypercube, it is that without the bias by few runs (Kelley 1935, epsilon squared).

    Args:
        one: the input.
        levels: its values in each run.
        values: of the result in each run, NaN where there is none.
    """
    there = np.isfinite(values)
    kept, result = [level for level, so in zip(levels, there, strict=True) if so], values[there]
    numbers = np.array([number_of(level[0]) for level in kept])
    sliced = len(set(kept)) > MOST_LEVELS and bool(np.isfinite(numbers).all())
    names, groups = _sliced(numbers) if sliced else _by_level(kept)
    means = np.array([result[groups == group].mean() for group in range(len(names))])
    places = np.array([numbers[groups == group].mean() for group in range(len(names))])
    if not np.isfinite(places).all():
        places = np.arange(len(names), dtype=float)
    return Effect(one.name, names, places, means, _share(result, means[groups], len(names) if sliced else 1))


def _sliced(numbers: Floats) -> tuple[list[str], Integers]:
    """Names of slices with equally many runs, and the slice of each run."""
    groups = np.empty(len(numbers), dtype=np.int64)
    groups[np.argsort(numbers, kind="stable")] = np.arange(len(numbers)) * SLICES // len(numbers)
    return [f"{numbers[groups == group].mean():.4g}" for group in range(SLICES)], groups


def _by_level(levels: list[Point]) -> tuple[list[str], Integers]:
    """Names of the different levels, and the level of each run."""
    order = {level: number for number, level in enumerate(sorted(set(levels), key=_rank))}
    return [_label(level) for level in order], np.array([order[level] for level in levels], dtype=np.int64)


def _rank(level: Point) -> tuple[float, Point]:
    number = number_of(level[0])
    return (number if np.isfinite(number) else np.inf), level


def effects(inputs: list[Input], samples: Samples, heading: str) -> list[Effect]:
    """Main effects of all inputs on a result."""
    parts = zip(inputs, samples.of(inputs), strict=True)
    return [effect(one, levels, samples.values[heading]) for one, levels in parts]


def conclusion(words: str, found: list[Effect]) -> str:
    """Which inputs carry a result's variance, as a sentence."""
    return shares_in_words(words, {one.name: one.share for one in found})


def shares_in_words(words: str, shares: dict[str, float]) -> str:
    """Shares of a result's variance by inputs alone, as a sentence; the rest is by several together."""
    ranked = sorted(shares.items(), key=lambda pair: -pair[1])
    listed = ", ".join(f"{name} {100 * max(share, 0.0):.0f} %" for name, share in ranked)
    rest = 1 - sum(max(share, 0.0) for share in shares.values())
    beside = f"; {100 * rest:.0f} % lie in what they do together" if rest > 0.05 else ""
    return f"of the variance of the {words} carries {listed}{beside}"


def _share(result: Floats, fitted: Floats, slices: int) -> float:
    """Share of the variance; without the bias by few runs from two slices on."""
    total = float(((result - result.mean()) ** 2).sum())
    between = float(((fitted - result.mean()) ** 2).sum())
    between -= (slices - 1) * (total - between) / max(len(result) - slices, 1)
    return min(max(between / total, 0.0), 1.0) if total else 0.0


def _label(level: Point) -> str:
    return ", ".join(text if np.isnan(number_of(text)) else f"{number_of(text):.4g}" for text in level)
