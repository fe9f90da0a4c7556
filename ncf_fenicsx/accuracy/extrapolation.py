"""Error bars from a sequence of values, each of a run refined by two from the last: observed order, limit, safety.

In the manner of the grid convergence index (Roache 1998): the finest value is off by the sum of the differences that
are yet to come, and the bar is that by a safety factor. The order with which they shrink is trusted where two observed
ones agree. Else first order is all that is trusted, or a lower one that is observed, and the largest of the last
differences counts, each taken to have shrunk like that since: a small one may be chance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from ncf_fenicsx.report.reference_solution import MOST_ORDER

SAFETY = 1.25
"""Roache's factor on what an observed order of three values or more tells."""
SAFETY_UNSEEN = 3.0
"""Roache's factor where first order is taken for granted: of two values, or of differences that do not shrink."""
LEAST_ORDER = 0.5
"""Observed order below which values do not settle: what is yet to come would be most of the bar."""
AGREE = 1.25
"""Factor between two observed orders up to which they agree."""
FORMAL_ORDER = 2.0
"""Order of the elements, above which none is trusted."""
TRUSTED_ORDER = 1.0
"""Order above which one that is observed once makes no bar smaller: edges of contact hop from element to element, and
what looks like a high order in a few values is mostly chance."""
LATEST = 3
"""Differences that a bar is made from, the last ones."""


class Basis(Enum):
    """Where a bar is from."""

    NONE = "one level"
    FIRST_ORDER = "first order taken for granted"
    ORDER = "observed order"
    DIFFERENCES = "differences, as no order settles"
    SPREAD = "spread of levels that may follow different branches"


@dataclass(frozen=True)
class Estimate:
    """What a sequence tells of its finest value.

    Attributes:
        value: the finest.
        bar: how far its limit is off it at most; infinite from one value.
        basis: where the bar is from.
        levels: number of values that it is from.
        order: observed; NaN where no order settles.
        limit: extrapolated with that order; NaN without.
    """

    value: float
    bar: float
    basis: Basis
    levels: int
    order: float = math.nan
    limit: float = math.nan

    @property
    def relative(self) -> float:
        """Bar over the size of the value; 0 where both are none."""
        return self.bar / abs(self.value) if self.value else (math.inf if self.bar else 0.0)


def estimate(values: Sequence[float], branches: bool = False) -> Estimate:
    """Error bar of the last of some values, from the coarsest on.

    Args:
        values: of runs that are refined by two from one to the next; one at least.
        branches: whether the runs may stand on different branches of solutions: then their spread is all there is.
    """
    if branches and len(values) > 1:
        latest = values[-(LATEST + 1) :]
        safety = SAFETY if len(values) > 2 else SAFETY_UNSEEN
        return Estimate(values[-1], safety * (max(latest) - min(latest)), Basis.SPREAD, len(latest))
    return of_differences(values[-1], [after - before for before, after in pairwise(values)])


def of_differences(value: float, differences: Sequence[float]) -> Estimate:
    """Error bar of a value, from the differences that led to it; those of fields are norms, without a sign."""
    latest = list(differences[-LATEST:])
    levels = len(latest) + 1
    if not latest:
        return Estimate(value, math.inf, Basis.NONE, levels)
    if len(latest) == 1:
        return Estimate(value, SAFETY_UNSEEN * abs(latest[0]), Basis.FIRST_ORDER, levels)
    orders = _orders(latest)
    if _agree(orders):
        order = min(*orders, FORMAL_ORDER)
        bar = SAFETY * abs(latest[-1]) / (2**order - 1)
        return Estimate(value, bar, Basis.ORDER, levels, order, value + latest[-1] / (2**order - 1))
    order = sum(orders) / len(orders)
    if not LEAST_ORDER <= order <= MOST_ORDER or abs(latest[0]) < max(abs(one) for one in latest):
        return Estimate(value, _envelope(latest, TRUSTED_ORDER), Basis.DIFFERENCES, levels)
    bar = _envelope(latest, min(order, TRUSTED_ORDER))
    return Estimate(value, bar, Basis.ORDER, levels, order, value + latest[-1] / (2**order - 1))


def _orders(differences: list[float]) -> list[float]:
    """Orders with which each difference has shrunk to the next; NaN where it changed its sign."""
    ratios = [before / after if after else math.inf for before, after in pairwise(differences)]
    return [math.log2(ratio) if ratio > 0 else math.nan for ratio in ratios]


def _agree(orders: list[float]) -> bool:
    """Whether two orders are sensible, and one."""
    sensible = len(orders) > 1 and all(LEAST_ORDER <= order <= MOST_ORDER for order in orders)
    return sensible and max(orders) <= AGREE * min(orders)


def _envelope(differences: list[float], order: float) -> float:
    """Bar from the largest difference, each shrunk with an order since; more where the last one is the largest."""
    sizes = [abs(one) for one in reversed(differences)]
    largest = max(size / 2 ** (order * age) for age, size in enumerate(sizes))
    safety = SAFETY_UNSEEN if sizes[0] > max(sizes[1:]) else SAFETY
    return safety * largest / (2**order - 1)
