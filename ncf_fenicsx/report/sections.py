"""Deformed sections across y: cut from a field file, and drawn with tools and mould in one window for all of a run."""

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
LEANS = np.tan(np.radians(1.0))
"""Slope of a cell's lower or upper edge from which on it is not flat."""
SCALES = (1, 2, 5, 10, 20, 50, 100)
"""How many times as large as lengths heights may be drawn."""
FLATTEST, HIGHEST = 12.0, 4.0
"""Width over height of a section above which its heights are drawn larger, and below which more of it is shown."""
ROUND_OFF = 1e-9
"""Share of the stack's width that positions are off by at most."""


@dataclass(frozen=True)
class Section:
    """Cells cut by a plane across y.

    Attributes:
        quads: deformed corners in the x-z plane in m, anticlockwise from the lower left, shape (cells, 4, 2).
        positions: undeformed centres of the quads in m, shape (cells, 2).
        layer: of each cell, 1 at the bottom.
        values: Vf of each cell, or the stress across it in kPa in a solid, which has no Vf.
    """

    quads: Floats
    positions: Floats
    layer: NDArray[np.int64]
    values: Floats

    def whole(self, scene: Scene) -> tuple[Floats, Floats]:
        """Quads and values, with their images beyond a symmetry plane x_min."""
        if scene.stack.sides.x_min != "symmetry":
            return self.quads, self.values
        left = self.quads[:, :, 0].min()
        image = (self.quads * [-1, 1] + [2 * left, 0])[:, [1, 0, 3, 2]]
        return np.concatenate([image, self.quads]), np.concatenate([self.values, self.values])


@dataclass(frozen=True)
class Window:
    """What all sections of a picture show.

    Attributes:
        x: lowest and highest x in m.
        z: lowest and highest height in m.
        exaggeration: how many times as large as lengths heights are drawn.
    """

    x: tuple[float, float]
    z: tuple[float, float]

    @property
    def exaggeration(self) -> int:
        """The least of `SCALES` that makes the section high enough to be read."""
        flatness = (self.x[1] - self.x[0]) / (self.z[1] - self.z[0])
        return next((scale for scale in SCALES if flatness <= scale * FLATTEST), SCALES[-1])

    @property
    def flatness(self) -> float:
        """Width over height of the drawing."""
        return (self.x[1] - self.x[0]) / (self.z[1] - self.z[0]) / self.exaggeration

    @property
    def scale(self) -> str:
        """The scale in words."""
        return scale_in_words(self.exaggeration)


def scale_in_words(exaggeration: float) -> str:
    """What is said of a drawing whose heights are larger than its lengths."""
    return "to scale" if exaggeration == 1 else f"heights drawn {exaggeration:g} times as large as lengths"


def cut(mesh: meshio.Mesh, y: float) -> Section:
    """Cells of a field file whose undeformed y range holds ``y`` (m), by their faces at the lowest y."""
    cells = mesh.cells_dict["hexahedron"]
    corners = mesh.points[cells][:, :, 1]
    low, high = corners.min(axis=1), corners.max(axis=1)
    y = min(max(y, low.min()), high.max() - ROUND_OFF * np.ptp(corners))
    held = np.flatnonzero((low <= y) & (y < high))
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


def window_of(sections: list[Section], tips: list[list[Floats]], scene: Scene) -> Window:
    """A window that shows the tools and all that leans by more than a degree, in each of some sections.

    Args:
        sections: of a run.
        tips: positions of the tips of tools and mould in m, in the scene's order, for each of them.
        scene: the case.
    """
    quads = np.concatenate([section.whole(scene)[0] for section in sections])
    margin = scene.stack.layers * scene.stack.thickness
    shown = [_leaning(quads)]
    floor, top = float(quads[:, :, 1].min()), float(quads[:, :, 1].max())
    tool_tops = [top + 0.25 * (top - floor)]
    for row in tips:
        for tool, tip in zip(scene.tool, row, strict=False):
            reach = np.array(tool.reach[0])
            shown.append(tip[0] + np.where(np.isfinite(reach), reach, [-2 * margin, 2 * margin]))
            tool_tops.append(min(float(tip[2] + np.ptp(tool.section()[:, 1])), 2 * top - floor))
    below = 0.06 * (max(tool_tops) - floor)
    z = (floor - below, max(tool_tops) + below)
    x = np.concatenate(shown) if any(map(len, shown)) else quads[:, :, 0]
    more = max(margin, (HIGHEST * (z[1] - z[0]) - np.ptp(x)) / 2)
    low, high = max(x.min() - more, quads[:, :, 0].min()), min(x.max() + more, quads[:, :, 0].max())
    return Window((float(low), float(high)), z)


def _leaning(quads: Floats) -> Floats:
    """X of the corners of cells that are not flat in m."""
    along = quads[:, [1, 2]] - quads[:, [0, 3]]
    leans = (np.abs(along[:, :, 1]) > LEANS * np.abs(along[:, :, 0])).any(axis=1)
    corners: Floats = quads[leans][:, :, 0].ravel()
    return corners


def draw_section(
    axes: Any, section: Section, scene: Scene, tips: list[Floats], window: Window, limits: tuple[float, float]
) -> Any:
    """Draw a section, mirrored at a symmetry plane, with the outlines of tools and mould.

    Args:
        axes: of Matplotlib.
        section: what is drawn.
        scene: the case.
        tips: positions of the tips of tools and mould in m, in the scene's order.
        window: what is shown.
        limits: of the colours.

    Returns:
        The coloured cells.
    """
    quads, values = section.whole(scene)
    cells = PolyCollection(list(MM * quads), array=values, cmap="viridis", edgecolors="0.6", linewidths=0.3)
    cells.set_clim(*limits)
    cells.set_snap(False)
    axes.add_collection(cells)
    for surface, tip in zip(scene.rigid_surfaces, tips, strict=True):
        axes.plot(*(MM * (surface.section() + tip[[0, 2]])).T, color="black", linewidth=1.5)
    axes.set(xlim=[MM * x for x in window.x], ylim=[MM * z for z in window.z])
    axes.set_aspect(window.exaggeration)
    axes.set(xlabel="x (mm)", ylabel="height (mm)")
    return cells
