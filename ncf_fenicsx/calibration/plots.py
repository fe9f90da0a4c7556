"""What is drawn of a calibration: laws over data, and residuals. The numbers are apart from the drawing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.calibration.calibrate import Calibration
from ncf_fenicsx.calibration.histories import History

Floats = NDArray[np.float64]
UNITS = {
    "angle": "angle (degrees)",
    "shear_stress": "shear stress (Pa)",
    "curvature": "curvature (1/m)",
    "moment": "moment per width (N)",
    "position": "position (m)",
    "deflection": "deflection (m)",
    "normal_force": "normal force (N)",
    "force": "force (N)",
    "volume_fraction": "fibre volume fraction",
    "permeability": "permeability along the fibres (m2)",
    "permeability_across": "permeability across the fibres (m2)",
}


@dataclass(frozen=True)
class Panel:
    """One picture of several.

    Attributes:
        title: above it.
        axes: words at its abscissa and ordinate.
        points: measured, by name: abscissas and ordinates.
        lines: of the laws, by name.
    """

    title: str
    axes: tuple[str, str]
    points: dict[str, tuple[Floats, Floats]] = field(default_factory=dict)
    lines: dict[str, tuple[Floats, Floats]] = field(default_factory=dict)


def panels(made: Calibration) -> list[Panel]:
    """All that is worth a look, as numbers."""
    found = []
    if made.fit is not None:
        fit = made.fit
        histories = {test.name: (test, History(fit.laws, test, fit.machine)) for test in made.tests}
        over_vf = Panel("compaction", ("fibre volume fraction", "pressure (kPa)"))
        over_time = Panel("compaction over time", ("time (s)", "pressure (kPa)"))
        off = Panel("residuals", ("pressure (kPa)", "thickness off by (%)"))
        for name, (test, history) in histories.items():
            measured, modelled = (np.asarray(p / 1e3, dtype=np.float64) for p in (test.pressure, history.pressure))
            for panel, across in ((over_vf, history.volume_fraction), (over_time, test.time)):
                panel.points[name], panel.lines[name] = (across, measured), (across, modelled)
            off.points[name] = (measured, 100 * history.off_in_thickness(test.pressure))
        found += [over_vf, over_time, off]
    for curve in made.curves:
        axes = UNITS[curve.x_name], UNITS[curve.y_name]
        found.append(Panel(curve.family, axes, {"measured": (curve.x, curve.y)}, {"law": (curve.x, curve.model)}))
    return found


def draw(drawn: list[Panel], path: Path) -> None:
    """Draw panels side by side as a PNG."""
    across = min(len(drawn), 3)
    down = math.ceil(len(drawn) / across)
    figure = Figure(figsize=(5 * across, 4 * down), layout="constrained")
    axes: Any = figure.subplots(down, across, squeeze=False)
    for place, panel in zip(axes.flat, drawn, strict=False):
        for number, (name, (x, y)) in enumerate(panel.points.items()):
            place.plot(x, y, f"C{number % 10}.", markersize=4, label=name)
        for number, (x, y) in enumerate(panel.lines.values()):
            place.plot(x, y, f"C{number % 10}-", linewidth=1)
        place.set(title=panel.title, xlabel=panel.axes[0], ylabel=panel.axes[1])
        place.grid(alpha=0.3)
        place.legend(fontsize="x-small")
    for place in axes.flat[len(drawn) :]:
        place.remove()
    FigureCanvasAgg(figure).print_png(path)
