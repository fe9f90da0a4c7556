"""One picture of a run, drawn from its results folder: force, Vf through the thickness, voids, deformed sections."""

from __future__ import annotations

import textwrap
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.report import tool_places
from ncf_fenicsx.report.reading import read_fields, read_history, read_record, read_snapshots, varies_along_y
from ncf_fenicsx.report.sections import (
    KPA,
    MM,
    Section,
    Window,
    cut,
    draw_section,
    label_of_values,
    window_of,
)
from ncf_fenicsx.report.side_view import draw_side_view
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]
MOST_SECTIONS = 3
WIDTH, SECTION_WIDTH = 13.0, 11.0
"""Width of the picture and of a section in it, in inches."""


def draw_summary(folder: Path) -> Path:
    """Draw ``summary.png`` of a results folder.

    Raises:
        ResultError: it cannot be written.
    """
    scene = Scene.from_table(tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8")))
    history, record = read_history(folder / "history.csv"), read_record(folder)
    snapshots = _shown(scene, read_snapshots(folder))
    meshes = [read_fields(folder / file) for _, file in snapshots]
    heights = float(meshes[0].points[:, 2].min()), float(meshes[0].points[:, 2].max())
    tips = [tool_places.tips(scene, history, heights, time) for time, _ in snapshots]
    wrinkle = record.get("wrinkle_measures")
    sections = [cut(mesh, _cut_at(scene, wrinkle, tips)) for mesh in meshes]
    window = window_of(sections, tips, scene)
    in_space = wrinkle is not None and varies_along_y(meshes[-1])
    figure, axes = _panels(window, len(sections), in_space)
    bars = [
        f"{found['title']}: {found['words']}" for found in record.get("accuracy", {}).get("quantities", {}).values()
    ]
    figure.suptitle("\n".join([scene.title, *bars, *textwrap.wrap(record.get("wrinkle", ""), 150)]))
    _draw_force(axes["force"], history, scene)
    _draw_profile(axes["profile"], sections, snapshots, tips, scene)
    (_draw_contact if wrinkle is None else _draw_wrinkle)(axes["contact"], history, scene)
    limits = min(s.values.min() for s in sections), max(s.values.max() for s in sections)
    for number, (section, (time, _)) in enumerate(zip(sections, snapshots, strict=True)):
        here = axes[f"section {number}"]
        cells = draw_section(here, section, scene, tips[number], window, limits)
        here.set_title(f"Deformed section at {time:.4g} s, {window.scale}")
        figure.colorbar(cells, ax=here, label=label_of_values(scene), shrink=0.9)
    if in_space:
        skin = draw_side_view(axes["space"], meshes[-1], scene, tips[-1][: len(scene.tool)])
        figure.colorbar(skin, ax=axes["space"], label="risen by (mm)", shrink=0.6, panchor=(0.5, 0.5))
    replace(folder / "summary.png", FigureCanvasAgg(figure).print_png)
    return folder / "summary.png"


def _cut_at(scene: Scene, wrinkle: dict[str, Any] | None, tips: list[list[Floats]]) -> float:
    """Y in m of the sections: that of the wrinkle's crest, else of the first tool."""
    if wrinkle is not None:
        return float(wrinkle["y_m"])
    return float(tips[0][0][1]) if scene.tool else 0.0


def _panels(window: Window, sections: int, in_space: bool) -> tuple[Figure, dict[str, Any]]:
    """A figure with its axes by name: curves in a row, a section in each of the next ones, and one in space."""
    height = 0.8 + min(max(SECTION_WIDTH / window.flatness, 1.2), 4.5)
    rows: list[Any] = [["force", "profile", "contact"], *([f"section {number}"] * 3 for number in range(sections))]
    heights = [3.4, *[height] * sections]
    if in_space:
        rows, heights = [*rows, ["space"] * 3], [*heights, 4.5]
    figure = Figure(figsize=(WIDTH, 0.7 + sum(heights)), layout="constrained")
    kinds: dict[Any, Any] = {"space": {"projection": "3d"}} if in_space else {}
    return figure, figure.subplot_mosaic(rows, height_ratios=heights, per_subplot_kw=kinds)


def _shown(scene: Scene, snapshots: list[tuple[float, str]]) -> list[tuple[float, str]]:
    """The snapshots at the ends of the path's pieces, the last ones if there are many."""
    times = np.array([time for time, _ in snapshots])
    wanted = [time for time in scene.milestones if time < times[-1]] + [float(times[-1])]
    nearest = sorted({int(np.abs(times - time).argmin()) for time in wanted})
    return [snapshots[number] for number in nearest[-MOST_SECTIONS:]]


def _abscissa(history: Any, scene: Scene) -> tuple[Floats, str]:
    """What curves are drawn over: how far a tool has gone down, or time where it does more than that."""
    if len(scene.segments) == 1:
        return MM * history["tool_displacement"], "tool displacement (mm)"
    return history["time"], "time (s)"


def _draw_force(axes: Any, history: Any, scene: Scene) -> None:
    over, label = _abscissa(history, scene)
    for number in range(len(scene.tool)):
        names = {name: numbered(f"tool_force{name}", number) for name in ("", "_x", "_y")}
        for name, column in names.items():
            if column in history.dtype.names:
                label_of = f"tool {number + 1}" + (f", along {name[1]}" if name else "")
                axes.plot(over, history[column], "--" if name else "o-", markersize=3, label=label_of)
    if len(axes.lines) > 1:
        axes.legend()
    axes.set(xlabel=label, ylabel="tool force (N)", title="Force on the tool (whole specimen)")
    axes.grid(alpha=0.3)


def _draw_profile(
    axes: Any, sections: list[Section], snapshots: list[tuple[float, str]], tips: list[list[Floats]], scene: Scene
) -> None:
    """Vf, or stress, over height in the column of cells that was nearest to the first tool's tip at each time."""
    heights: list[float] = []
    for number, (section, (time, _)) in enumerate(zip(sections, snapshots, strict=True)):
        middle = section.quads.mean(axis=1)
        nearest = np.abs(middle[:, 0] - (tips[number][0][0] if scene.tool else 0.0)).argmin()
        aside = np.abs(section.positions[:, 0] - section.positions[nearest, 0])
        column = np.flatnonzero(aside <= 1e-6 * np.ptp(section.positions[:, 0]) + 1e-12)
        column = column[np.argsort(middle[column, 1])]
        axes.plot(section.values[column], MM * middle[column, 1], "o-", color=f"C{number}", label=f"{time:.4g} s")
        heights += [section.quads[column][:, :, 1].min(), section.quads[column][:, :, 1].max()]
    if scene.laws.solid is None:
        axes.axvline(scene.stack.initial_volume_fraction, color="grey", linestyle=":", label="undeformed")
    axes.legend()
    axes.set_ylim(MM * min(heights), MM * max(heights))
    axes.set(xlabel=label_of_values(scene), ylabel="height (mm)", title="Through the stack under the tool")
    axes.grid(alpha=0.3)


def _draw_contact(axes: Any, history: Any, scene: Scene) -> None:
    """Openings between the layers, and the pressure under the first tool."""
    over, label = _abscissa(history, scene)
    for layer in range(1, scene.stack.layers):
        if f"gap_max_{layer}" in history.dtype.names:
            axes.plot(
                over, MM * history[f"gap_max_{layer}"], "o-", markersize=3, label=f"layers {layer} and {layer + 1}"
            )
    if axes.lines:
        axes.legend()
        axes.set(xlabel=label, ylabel="widest opening (mm)", title="Voids between the layers")
    elif "pressure_max" in history.dtype.names:
        axes.plot(over, KPA * history["pressure_max"], "o-", markersize=3)
        axes.set(xlabel=label, ylabel="largest contact pressure (kPa)", title="Pressure under the tool")
    axes.grid(alpha=0.3)


def _draw_wrinkle(axes: Any, history: Any, scene: Scene) -> None:
    """Height of the wrinkle of each layer."""
    over, label = _abscissa(history, scene)
    for layer in range(1, scene.stack.layers + 1):
        height = MM * history[f"wrinkle_height_{layer}"]
        axes.plot(over, height, "o-", markersize=3, label=f"top of layer {layer}")
    axes.legend()
    axes.set(xlabel=label, ylabel="height (mm)", title="Highest wrinkle")
    axes.grid(alpha=0.3)
