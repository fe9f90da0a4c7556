"""One picture of a run, drawn from its results folder: force, Vf through the thickness, the deformed section."""

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

from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]
MM, KPA = 1e3, 1e-3


@dataclass(frozen=True)
class Section:
    """Cells cut by the plane across the stack at the tool's y.

    Attributes:
        quads: deformed corners in the x-z plane in m, shape (cells, 4, 2).
        places: undeformed centres of the quads in m, shape (cells, 2).
        values: Vf of each cell, or the stress across it in kPa in a solid, which has no Vf.
    """

    quads: Floats
    places: Floats
    values: Floats


def draw_summary(folder: Path) -> Path:
    """Draw ``summary.png`` of a results folder."""
    scene = Scene.from_table(tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8")))
    history = read_history(folder / "history.csv")
    mesh = meshio.read(sorted((folder / "fields").glob("*.vtu"))[-1])
    time, top = float(history["time"][-1]), float(mesh.points[:, 2].max())
    tip = scene.tool[0].tip(top, time) if scene.tool else np.zeros(3)
    section = cut(mesh, tip[1])
    figure = Figure(figsize=(12, 7.5), layout="constrained")
    axes = figure.subplot_mosaic([["force", "profile"], ["section", "section"]], height_ratios=[1, 0.9])
    figure.suptitle(f"{scene.title}: {time:.4g} s")
    _draw_force(axes["force"], history)
    _draw_profile(axes["profile"], section, tip[0], scene)
    _draw_section(figure, axes["section"], section, scene, tip)
    FigureCanvasAgg(figure).print_png(folder / "summary.png")
    return folder / "summary.png"


def read_history(path: Path) -> Any:
    """Columns of a ``history.csv`` by name, each a vector."""
    return np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))


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
    return Section(deformed, flat.mean(axis=1), scale * fields[name]["hexahedron"][held])


def _draw_force(axes: Any, history: Any) -> None:
    axes.plot(MM * history["tool_displacement"], history["tool_force"], "o-", markersize=3)
    axes.set(xlabel="tool displacement (mm)", ylabel="tool force (N)", title="Force on the tool (whole specimen)")
    axes.grid(alpha=0.3)


def _draw_profile(axes: Any, section: Section, x: float, scene: Scene) -> None:
    """Vf, or stress, over height in the column of cells nearest to the tool's tip."""
    middle = section.quads.mean(axis=1)
    distance = np.abs(section.places[:, 0] - x)
    column = np.flatnonzero(distance <= distance.min() + 1e-6 * np.ptp(section.places[:, 0]) + 1e-12)
    column = column[np.argsort(middle[column, 1])]
    for cell in column:
        low, high = section.quads[cell][:, 1].min(), section.quads[cell][:, 1].max()
        axes.plot([section.values[cell]] * 2, [MM * low, MM * high], "-", color="C3", linewidth=3)
    axes.plot(section.values[column], MM * middle[column, 1], "o", color="C3", markersize=4)
    if scene.laws.solid is None:
        axes.axvline(scene.stack.initial_volume_fraction, color="grey", linestyle=":", label="undeformed")
        axes.legend(loc="lower right")
    axes.set(xlabel=_label(scene), ylabel="height (mm)", title="Through the stack under the tool")
    axes.grid(alpha=0.3)


def _label(scene: Scene) -> str:
    return "fibre volume fraction" if scene.laws.solid is None else "stress across the layers (kPa)"


def _draw_section(figure: Figure, axes: Any, section: Section, scene: Scene, tip: Floats) -> None:
    quads, values = section.quads, section.values
    if scene.stack.sides.x_min == "symmetry":
        left = quads[:, :, 0].min()
        mirrored = quads * [-1, 1] + [2 * left, 0]
        quads, values = np.concatenate([mirrored, quads]), np.concatenate([values, values])
    cells = PolyCollection(list(MM * quads), array=values, cmap="viridis", edgecolors="0.6", linewidths=0.4)
    cells.set_snap(False)
    axes.add_collection(cells)
    figure.colorbar(cells, ax=axes, label=_label(scene), shrink=0.9)
    x, _, z = tip
    top = quads[:, :, 1].max()
    if scene.tool:
        axes.plot(*(MM * (scene.tool[0].section() + np.array([x, z]))).T, color="black", linewidth=1.5)
    reach = 2.2 * scene.stack.layers * scene.stack.thickness
    low, high = max(x - reach, quads[:, :, 0].min()), min(x + reach, quads[:, :, 0].max())
    floor = quads[:, :, 1].min()
    axes.set(xlim=(MM * low, MM * high), ylim=(MM * floor - 0.3, MM * (1.12 * max(top, z) - 0.12 * floor)))
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="height (mm)", title="Deformed section under the tool, to scale")
