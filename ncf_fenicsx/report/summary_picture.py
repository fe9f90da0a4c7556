"""One picture of a run, drawn from its results folder: force, Vf through the thickness, voids, deformed sections."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.kinds import numbered
from ncf_fenicsx.report import tool_places
from ncf_fenicsx.report.reading import read_history, read_snapshots
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]
MM, KPA = 1e3, 1e-3


MOST_SECTIONS = 3


@dataclass(frozen=True)
class Section:
    """Cells cut by a plane across y.

    Attributes:
        quads: deformed corners in the x-z plane in m, shape (cells, 4, 2).
        positions: undeformed centres of the quads in m, shape (cells, 2).
        layer: of each cell, 1 at the bottom.
        values: Vf of each cell, or the stress across it in kPa in a solid, which has no Vf.
    """

    quads: Floats
    positions: Floats
    layer: NDArray[np.int64]
    values: Floats


def cut(mesh: meshio.Mesh, y: float) -> Section:
    """Cells of a field file whose undeformed y range holds ``y`` (m), by their faces at the lowest y."""
    cells = mesh.cells_dict["hexahedron"]
    corners = mesh.points[cells][:, :, 1]
    low, high = corners.min(axis=1), corners.max(axis=1)
    y = min(max(y, low.min()), high.max() - 1e-9 * np.ptp(corners))
    held = np.flatnonzero((low <= y + 1e-12) & (y < high - 1e-12))
    front = np.take_along_axis(cells[held], np.argsort(corners[held], axis=1, kind="stable")[:, :4], axis=1)
    flat = mesh.points[front][:, :, [0, 2]]
    around = flat - flat.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(around[:, :, 1], around[:, :, 0]), axis=1)
    nodes = np.take_along_axis(front, order, axis=1)
    deformed = (mesh.points + mesh.point_data["displacement"])[nodes][:, :, [0, 2]]
    fields = mesh.cell_data_dict
    name, scale = ("volume_fraction", 1.0) if "volume_fraction" in fields else ("stress_33", KPA)
    layer = fields["layer"]["hexahedron"][held]
    return Section(deformed, flat.mean(axis=1), layer, scale * fields[name]["hexahedron"][held])


def label_of_values(scene: Scene) -> str:
    """What the values of a section are."""
    return "fibre volume fraction" if scene.laws.solid is None else "stress across the layers (kPa)"


def draw_section(axes: Any, section: Section, scene: Scene, tips: list[Floats], limits: tuple[float, float]) -> Any:
    """Draw a section to scale, mirrored at a symmetry plane, with the outlines of tools and mould.

    Args:
        axes: of Matplotlib.
        section: what is drawn.
        scene: the case.
        tips: positions of the tips of tools and mould in m, in the scene's order.
        limits: of the colours.

    Returns:
        The coloured cells.
    """
    quads, values = section.quads, section.values
    if scene.stack.sides.x_min == "symmetry":
        left = quads[:, :, 0].min()
        quads = np.concatenate([quads * [-1, 1] + [2 * left, 0], quads])
        values = np.concatenate([values, values])
    cells = PolyCollection(list(MM * quads), array=values, cmap="viridis", edgecolors="0.6", linewidths=0.3)
    cells.set_clim(*limits)
    cells.set_snap(False)
    axes.add_collection(cells)
    for surface, tip in zip(scene.rigid_surfaces, tips, strict=True):
        axes.plot(*(MM * (surface.section() + tip[[0, 2]])).T, color="black", linewidth=1.5)
    low, high = _window(quads, scene, tips)
    floor, top = quads[:, :, 1].min(), quads[:, :, 1].max()
    axes.set(xlim=(MM * low, MM * high), ylim=(MM * floor - 0.5, MM * (top + 0.25 * (top - floor))))
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="height (mm)")
    return cells


def _window(quads: Floats, scene: Scene, tips: list[Floats]) -> tuple[float, float]:
    """Extent in x (m) that is shown: around the tools, wide enough for the stack's thickness to be seen."""
    reach = 3.0 * scene.stack.layers * scene.stack.thickness
    x = [tip[0] for tip in tips[: len(scene.tool)]] or [float(quads[:, :, 0].mean())]
    return max(min(x) - reach, quads[:, :, 0].min()), min(max(x) + reach, quads[:, :, 0].max())


def draw_summary(folder: Path) -> Path:
    """Draw ``summary.png`` of a results folder."""
    scene = Scene.from_table(tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8")))
    history = read_history(folder / "history.csv")
    snapshots = _shown(scene, read_snapshots(folder))
    meshes = [meshio.read(folder / file) for _, file in snapshots]
    heights = float(meshes[0].points[:, 2].min()), float(meshes[0].points[:, 2].max())
    tips = [tool_places.tips(scene, history, heights, time) for time, _ in snapshots]
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
        distance = np.abs(section.positions[:, 0] - (tips[-1][0][0] if scene.tool else 0.0))
        column = np.flatnonzero(distance <= distance.min() + 1e-6 * np.ptp(section.positions[:, 0]) + 1e-12)
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
