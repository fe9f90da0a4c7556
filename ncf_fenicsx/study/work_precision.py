"""The work-precision picture: error over run time, one line a method, the best front marked and named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ncf_fenicsx.report.study_panels import ERRORS, LEAST, front
from ncf_fenicsx.workers.rows import Row

MARKERS = "osD^v<>PX*hp"
COLOURS = 10
"""That Matplotlib takes in turn; a method that has the colour of another one has a broken line."""


def draw_work_precision(rows: list[Row], title: str, path: Path) -> None:
    """Draw the picture, a field for each error that the rows have."""
    errors = [name for name in ERRORS if any(row[name] for row in rows)]
    figure = Figure(figsize=(6.2 * min(len(errors), 2) + 3.5, 5.2 * ((len(errors) + 1) // 2)), layout="constrained")
    axes: Any = figure.subplots((len(errors) + 1) // 2, min(len(errors), 2), squeeze=False).ravel()
    figure.suptitle(title)
    for here, error in zip(axes, errors, strict=False):
        _draw(here, [row for row in rows if row[error]], error)
    for spare in axes[len(errors) :]:
        spare.remove()
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", frameon=False)
    FigureCanvasAgg(figure).print_png(path)


def _draw(axes: Any, rows: list[Row], error: str) -> None:
    points = [(float(row["seconds"]), max(float(row[error]), LEAST)) for row in rows]
    best = front(points)
    for number, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        own = [(point, row["level"]) for point, row in zip(points, rows, strict=True) if row["method"] == method]
        line = {"marker": MARKERS[number % len(MARKERS)], "ls": "-" if number < COLOURS else "--"}
        axes.plot(*zip(*(point for point, _ in own), strict=True), **line, ms=5, lw=1, label=method)
        for point, level in own:
            if point in best:
                axes.annotate(level, point, fontsize=7, xytext=(0, -9), textcoords="offset points", ha="center")
    axes.plot(*zip(*best, strict=True), "k-", lw=6, alpha=0.15, zorder=0, label="best front")
    axes.set(xscale="log", yscale="log", xlabel="wall time (s), without compiling forms", ylabel=ERRORS[error])
    axes.grid(which="both", alpha=0.25)
