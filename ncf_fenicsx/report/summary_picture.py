"""One picture of a run, drawn from its results folder: force, Vf through the thickness, voids, deformed sections."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.kinds import numbered
from ncf_fenicsx.report.sections import KPA, MM, Section, cut, draw_section, label_of_values
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]

MOST_SECTIONS = 3


def draw_summary(folder: Path) -> Path:
    """Draw ``summary.png`` of a results folder."""
    scene = Scene.from_table(tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8")))
    history = read_history(folder / "history.csv")
    snapshots = _shown(scene, read_snapshots(folder))
    meshes = [meshio.read(folder / file) for _, file in snapshots]
    tips = [_tips(scene, history, meshes[0], time) for time, _ in snapshots]
    y = tips[0][0][1] if scene.tool else 0.0
    sections = [cut(mesh, y) for mesh in meshes]
    figure = Figure(figsize=(13, 4.0 + 2.6 * len(sections)), layout="constrained")
    layout: list[Any] = [["force", "profile", "contact"], *([f"section {n}"] * 3 for n in range(len(sections)))]
    axes = figure.subplot_mosaic(layout, height_ratios=[1.25, *[1.0] * len(sections)])
    figure.suptitle(scene.title)
    _draw_force(axes["force"], history, scene)
    _draw_profile(axes["profile"], sections, snapshots, tips, scene)
    _draw_contact(axes["contact"], history, scene)
    limits = min(s.values.min() for s in sections), max(s.values.max() for s in sections)
    for number, (section, (time, _)) in enumerate(zip(sections, snapshots, strict=True)):
        here = axes[f"section {number}"]
        cells = draw_section(here, section, scene, tips[number], limits)
        here.set_title(f"Deformed section at {time:.4g} s, to scale")
        figure.colorbar(cells, ax=here, label=label_of_values(scene), shrink=0.9)
    FigureCanvasAgg(figure).print_png(folder / "summary.png")
    return folder / "summary.png"


def read_history(path: Path) -> Any:
    """Columns of a ``history.csv`` by name, each a vector."""
    return np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))


def read_record(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a results folder."""
    return dict(json.loads((folder / "run.json").read_text(encoding="utf-8")))


def read_snapshots(folder: Path) -> list[tuple[float, str]]:
    """Times in s and names of the field files of a results folder."""
    entries = ElementTree.parse(folder / "fields.pvd").getroot().iter("DataSet")
    return [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in entries]


def _shown(scene: Scene, snapshots: list[tuple[float, str]]) -> list[tuple[float, str]]:
    """The snapshots at the ends of the path's pieces, the last ones if there are many."""
    times = np.array([time for time, _ in snapshots])
    wanted = [time for time in scene.milestones if time < times[-1]] + [float(times[-1])]
    nearest = sorted({int(np.abs(times - time).argmin()) for time in wanted})
    return [snapshots[number] for number in nearest[-MOST_SECTIONS:]]


def _tips(scene: Scene, history: Any, mesh: meshio.Mesh, time: float) -> list[Floats]:
    """Places in m of the tips of tools and mould; the heights of tools as the run found them."""
    top, bottom = float(mesh.points[:, 2].max()), float(mesh.points[:, 2].min())
    tips = []
    for number, tool in enumerate(scene.tool):
        tip = tool.tip(top, time)
        lowered = np.interp(time, history["time"], history[numbered("tool_displacement", number)])
        tips.append(np.array([tip[0], tip[1], tool.tip(top, 0.0)[2] - lowered]))
    return tips + ([scene.mould.tip(bottom)] if scene.mould is not None else [])


def _abscissa(history: Any, scene: Scene) -> tuple[Floats, str]:
    """What curves are drawn over: how far a tool has gone down, or time where it does more than that."""
    if len(scene.segments) == 1:
        return MM * history["tool_displacement"], "tool displacement (mm)"
    return history["time"], "time (s)"


def _draw_force(axes: Any, history: Any, scene: Scene) -> None:
    over, label = _abscissa(history, scene)
    for number in range(len(scene.tool)):
        axes.plot(over, history[numbered("tool_force", number)], "o-", markersize=3, label=f"tool {number + 1}")
    if len(scene.tool) > 1:
        axes.legend()
    axes.set(xlabel=label, ylabel="tool force (N)", title="Force on the tool (whole specimen)")
    axes.grid(alpha=0.3)


def _draw_profile(
    axes: Any, sections: list[Section], snapshots: list[tuple[float, str]], tips: list[list[Floats]], scene: Scene
) -> None:
    """Vf, or stress, over height in the column of cells that were under the first tool's tip."""
    for number, (section, (time, _)) in enumerate(zip(sections, snapshots, strict=True)):
        middle = section.quads.mean(axis=1)
        distance = np.abs(section.places[:, 0] - (tips[-1][0][0] if scene.tool else 0.0))
        column = np.flatnonzero(distance <= distance.min() + 1e-6 * np.ptp(section.places[:, 0]) + 1e-12)
        column = column[np.argsort(middle[column, 1])]
        axes.plot(section.values[column], MM * middle[column, 1], "o-", color=f"C{number}", label=f"{time:.4g} s")
    if scene.laws.solid is None:
        axes.axvline(scene.stack.initial_volume_fraction, color="grey", linestyle=":", label="undeformed")
    axes.legend()
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
