"""Arcs that outlines are drawn with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def arc(radius: float, start: float, end: float, points: int = 181) -> NDArray[np.float64]:
    """Arc about the origin in the plane across y, in m, shape (points, 2).

    Args:
        radius: its radius in m.
        start: angle in degrees from straight down, towards x.
        end: the same of its other end.
        points: number of points.
    """
    angle = np.radians(np.linspace(start, end, points))
    return radius * np.stack([np.sin(angle), -np.cos(angle)], axis=1)


def circle(radius: float) -> NDArray[np.float64]:
    """Circle that stands on the tip, in m, shape (181, 2)."""
    return arc(radius, -180, 180) + np.array([0.0, radius])
