"""How much of a correction Newton's method takes: as much as the forces out of balance do work along it.

Where faces stick and slip in turns, whole corrections go back and forth between two states, each the answer to the
other's tangent. Along a correction d the forces out of balance do the work r(u + s d) . d, which falls from s = 0 to
none at the best share s. It is searched for only where a whole correction leaves a work of the other sign that is a
large part of the first: near the solution corrections are whole, and convergence is quadratic (Matthies and Strang,
Int. J. Numer. Methods Eng. 14, 1979).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

LEFT = 0.5
"""Share of the first work, of either sign, that a correction may leave."""
MOST = 10
"""Evaluations of the work in a search; each costs a residual."""
EDGE = 0.1
"""Least part of the interval that is cut off: interpolation does not find where the work jumps, as a face slips;
after two shares on one side of it, the interval is halved."""
LINE_SEARCHES = {
    "full": "basic",
    "work": "basic",  # by the function below, before PETSc takes what is left whole
    "critical_point": "cp",
    "error_oriented": "nleqerr",
    "residual": "bt",
}
"""Names of PETSc for those of a scene."""


def step_options(line_search: str) -> dict[str, str]:
    """Options of SNES on the length of its steps, for a scene's line search."""
    if line_search == "trust_region":
        return {"ncf_snes_tr_norm_type": "infinity", "ncf_snes_tr_fallback_type": "newton"}
    return {"ncf_snes_linesearch_type": LINE_SEARCHES[line_search]}


def share_of_step(at_start: float, work: Callable[[float], float]) -> float:
    """Share of a correction at which the work of the forces out of balance is small or has passed zero.

    Args:
        at_start: the work in J at share 0. Where it is negative the tangent is not positive definite: all is taken.
        work: gives the work at a share.
    """

    def known(share: float) -> float:
        """The work at a share; where forces are no numbers, as beyond the laws' range, the correction is too long."""
        found = work(share)
        return found if math.isfinite(found) else -at_start

    if at_start <= 0 or (at_end := known(1.0)) >= -LEFT * at_start:
        return 1.0
    low, high, before, beyond = 0.0, 1.0, at_start, at_end
    share, side, halve = 1.0, 0, False
    for _ in range(MOST):
        zero = (low * beyond - high * before) / (beyond - before)
        edge = EDGE * (high - low)
        share = (low + high) / 2 if halve else min(max(zero, low + edge), high - edge)
        now = known(share)
        if abs(now) <= LEFT * at_start:
            break
        halve, side = side == np.sign(now), int(np.sign(now))
        if now > 0:
            low, before = share, now
        else:
            high, beyond = share, now
    return share if math.isfinite(work(share)) else low
