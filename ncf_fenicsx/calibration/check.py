"""The tests of a calibration as scenes of one element, run with the fitted laws and held against what was measured."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.calibration.fitting import LOWEST, Fit
from ncf_fenicsx.calibration.histories import History
from ncf_fenicsx.calibration.specimens import Compaction
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation import run

Floats = NDArray[np.float64]
STRAIGHT = 2e-3
"""Deviation of the path of the scene from that of the test, over its whole travel."""
MOST_PIECES = 40
SIDE = 10e-3
WITHIN = 1.2
"""Scatter of a simulated test over that of the fit which still is within the noise."""
ROWS = 100
"""Least number of steps of a scene: its force is straight between them."""
LEAST = 0.001
"""Relative difference in thickness that steps and contact of the scene make."""


@dataclass(frozen=True)
class Checked:
    """How far a simulated test is off.

    Attributes:
        name: of the test.
        fitted: root mean square of the thickness at given pressure, over it, of the laws.
        simulated: the same of the scene.
    """

    name: str
    fitted: float
    simulated: float

    @property
    def holds(self) -> bool:
        """Whether the scene gives the data back within the noise that the laws leave."""
        return self.simulated <= WITHIN * self.fitted + LEAST


def check(fit: Fit, tests: list[Compaction]) -> list[Checked]:
    """Simulate each test and hold it against what was measured.

    Raises:
        SceneError: a test cannot be run.
    """
    with tempfile.TemporaryDirectory() as folder:
        return [_checked(fit, test, Path(folder) / str(number)) for number, test in enumerate(tests)]


def _checked(fit: Fit, test: Compaction, folder: Path) -> Checked:
    result = run(scene_of(fit, test), folder)
    if not result.done:
        raise SceneError(f"--check: {test.name}: {result.reason}")
    time, force = (np.array([row[name] for row in result.history]) for name in ("time", "tool_force"))
    simulated = np.interp(test.time - test.time[0], time, force) / (4 * SIDE**2)
    history = History(fit.laws, test, fit.machine)
    rows = test.pressure > LOWEST * test.pressure.max()
    fitted = history.off_in_thickness(test.pressure)[rows]
    ran = history.between(simulated, test.pressure)[rows]
    return Checked(test.name, *(float(np.sqrt(np.mean(off**2))) for off in (fitted, ran)))


def scene_of(fit: Fit, test: Compaction) -> Scene:
    """One layer of one element under a plate that closes as the test did, each layer of it by its share."""
    depth = np.maximum(test.initial_thickness - test.thickness(fit.machine), 0.0) / test.layers
    time = test.time - test.time[0]
    return Scene.from_table(
        {
            "title": test.name,
            "gravity": "0 m/s^2",
            "stack": {
                "layers": 1,
                "thickness": f"{test.initial_thickness / test.layers!r} m",
                "areal_density": f"{test.areal_density!r} kg/m^2",
                "fibre_density": f"{test.fibre_density!r} kg/m^3",
                "size": [f"{SIDE} m", f"{SIDE} m"],
                "divisions": [1, 1],
                "grading": [0.0, 0.0],
            },
            "laws": {family: {"kind": law.kind, **law.model_dump()} for family, law in fit.laws.items()},
            "tool": {"kind": "plate", "penalty": 1000.0, "path": _path(time, depth)},
            "solver": {"first_step": f"{time[-1] / ROWS} s", "largest_step": f"{time[-1] / ROWS} s"},
            "output": {"picture": False},
        }
    )


def _path(time: Floats, depth: Floats) -> list[dict[str, Any]]:
    """Straight pieces between the rows that a path cannot do without."""
    kept = [0, len(time) - 1]
    while len(kept) <= MOST_PIECES:
        off = np.abs(depth - np.interp(time, time[kept], depth[kept]))
        if off.max() <= STRAIGHT * depth.max():
            break
        kept = sorted([*kept, int(off.argmax())])
    pieces: list[dict[str, Any]] = []
    for duration, down in zip(np.diff(time[kept]), np.diff(depth[kept]), strict=True):
        if abs(down) < STRAIGHT * depth.max() / MOST_PIECES:
            pieces.append({"hold": f"{float(duration)!r} s"})
        else:
            travel = ["0 m", "0 m", f"{-float(down)!r} m"]
            pieces.append({"travel": travel, "speed": f"{float(abs(down) / duration)!r} m/s"})
    return pieces


def in_words(checked: list[Checked]) -> str:
    """Markdown table of how far each test is off."""
    lines = ["| test | thickness at given pressure off by, laws | in a run | within the noise |", "|---|---|---|---|"]
    for test in checked:
        held = "yes" if test.holds else "no"
        lines.append(f"| {test.name} | {100 * test.fitted:.3g} % | {100 * test.simulated:.3g} % | {held} |")
    return "\n".join(lines)
