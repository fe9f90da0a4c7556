"""Where a contact ends between two nodes of a line. Plain arrays only.

Beside a contact of smooth surfaces the gap grows with the distance from its edge to the power of 3/2 (Hertz): to the
power of 2/3 it is a straight line, whose zero is the edge. The gap itself, a thousand times larger than penetrations of
stiff contact, would always end at the last node. Only where a surface cuts into another one, as deep as the gaps beside
it, is the gap a straight line through the edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

EXPONENT = 2 / 3
DEEP = 0.4
"""Penetration over the gap beside a contact from which on a surface cuts into another one."""


def extent(along: Floats, gap: Floats) -> float:
    """Extent in m of the contact along some lines of nodes; 0 without contact.

    Args:
        along: coordinates of the nodes along each line in m, growing, shape (lines, nodes).
        gap: at each node in m, above 0 where open, shape (lines, nodes).
    """
    touching = (gap <= 0).any(axis=1)
    if not touching.any():
        return 0.0
    x, g = along[touching], gap[touching]
    last = max(map(_last_edge, x, g))
    first = -max(map(_last_edge, -x[:, ::-1], g[:, ::-1]))
    return float(last - first)


def _last_edge(x: Floats, gap: Floats) -> float:
    """Coordinate in m at which the last contact on a line ends.

    With one open node beside it the contact ends half-way to that.
    """
    node = int(np.flatnonzero(gap <= 0)[-1])
    if node == len(x) - 1:
        return float(x[-1])
    low, high = x[node], x[node + 1]
    if node + 2 == len(x) or not gap[node + 2] > gap[node + 1]:
        return float((low + high) / 2)
    if -gap[max(node - 1, 0) : node + 1].min() > DEEP * gap[node + 2]:
        return float(low + (high - low) * gap[node] / (gap[node] - gap[node + 1]))
    near, far = gap[node + 1 : node + 3] ** EXPONENT
    within = (low + x[max(node - 1, 0)]) / 2  # the share of the last node reaches half-way to the one before
    return float(max(within, high - near * (x[node + 2] - high) / (far - near)))
