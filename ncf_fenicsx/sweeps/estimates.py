"""Numbers with their confidence."""

from __future__ import annotations

from dataclasses import dataclass

CONFIDENCE = 0.95
"""Probability that an interval holds the true number."""


@dataclass(frozen=True)
class Estimate:
    """A number, and the ends of its interval of confidence where it has one."""

    value: float
    low: float | None = None
    high: float | None = None


Estimates = dict[str, Estimate]
"""By their names."""
