"""Vertical sections through field files, and how they are drawn with the rigid surfaces they meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import meshio
import numpy as np
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]
MM, KPA = 1e3, 1e-3


@dataclass(frozen=True)
class Section:
    """Cells cut by a plane across y.

    Attributes:
        quads: deformed corners in the x-z plane in m, shape (cells, 4, 2).
        places: undeformed centres of the quads in m, shape (cells, 2).
        layer: of each cell, 1 at the bottom.
        values: Vf of each cell, or the stress across it in kPa in a solid, which has no Vf.
    """

    quads: Floats
    places: Floats
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
        tips: places of the tips of tools and mould in m, in the scene's order.
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
