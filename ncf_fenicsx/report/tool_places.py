"""Where tools and mould were at a time, as a history tells it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]


def tips(scene: Scene, history: Any, heights: tuple[float, float], time: float) -> list[Floats]:
    """Positions in m of the tips of tools and mould; the heights of tools as the run found them.

    Args:
        scene: the case.
        history: its columns by name.
        heights: of the undeformed stack's bottom and top in m.
        time: in s.
    """
    bottom, top = heights
    found = []
    for number, tool in enumerate(scene.tool):
        x, y, _ = tool.tip(top, time)
        lowered = np.interp(time, history["time"], history[numbered("tool_displacement", number)])
        found.append(np.array([x, y, tool.tip(top, 0.0)[2] - lowered]))
    return found + ([scene.mould.tip(bottom)] if scene.mould is not None else [])
