"""Whether a run leaves the data that its laws are given by: it then goes on by extrapolation, and says so."""

from __future__ import annotations

from typing import Any

from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.progress_bar import ProgressBar


class DataRange:
    """Watches the accepted steps of a run.

    Args:
        scene: the case.
        progress: where a caution is said, once for each law.

    Attributes:
        left: by law, when its data were left first (s), their end that was passed, and the Vf farthest beyond it.
    """

    def __init__(self, scene: Scene, progress: ProgressBar) -> None:
        laws = [(f"laws.{law.family}", law.data_range) for law in scene.laws.chosen]
        permeability = scene.output.permeability
        laws += [("output.permeability", permeability.data_range)] if permeability is not None else []
        self._ranges = {name: limits for name, limits in laws if limits is not None}
        self._progress = progress
        self.left: dict[str, dict[str, float]] = {}

    def watch(self, time: float, row: dict[str, float]) -> None:
        """Look at a step that ends at a time (s), by its row of the history."""
        for name, (low, high) in self._ranges.items():
            least, most = row.get("vf_min", low), row.get("vf_max", high)
            if most > high:
                self._note(name, time, high, most)
            elif least < low:
                self._note(name, time, low, least)

    def _note(self, name: str, time: float, limit: float, vf: float) -> None:
        if name not in self.left:
            self._progress.caution(
                f"{name}: Vf {vf:.4g} at {time:.6g} s is beyond the data, which end at {limit:.4g}: "
                "from here on it is extrapolated"
            )
        found = self.left.setdefault(name, {"time": time, "limit": limit, "volume_fraction": vf})
        if abs(vf - found["limit"]) > abs(found["volume_fraction"] - found["limit"]):
            found["volume_fraction"] = vf

    def record(self) -> dict[str, Any]:
        """What the record of the run says of it."""
        return {"beyond_data": self.left} if self.left else {}
