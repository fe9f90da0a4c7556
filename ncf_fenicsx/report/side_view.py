"""The stack seen from the side, in three dimensions: for a wrinkle that is not the same all along y."""

from __future__ import annotations

from typing import Any

import meshio
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]
from numpy.typing import NDArray

from ncf_fenicsx.report.sections import MM, SCALES, scale_in_words
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]

FACES = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
"""Corners of the faces of a hexahedron in a VTK file."""
LOWEST = 0.15
"""Height of the drawing over its length below which heights are drawn larger."""


def draw_side_view(axes: Any, mesh: meshio.Mesh, scene: Scene, tips: list[Floats]) -> Any:
    """Draw the top and the sides of a deformed stack, coloured by how far they have risen, and outlines of the tools.

    Args:
        axes: of Matplotlib, in three dimensions.
        mesh: of a field file.
        scene: the case.
        tips: positions of the tips of the tools in m, in the scene's order.

    Returns:
        The coloured faces.
    """
    faces = _outside(mesh)
    deformed = MM * (mesh.points + mesh.point_data["displacement"])
    risen = MM * mesh.point_data["displacement"][faces][:, :, 2].mean(axis=1)
    skin = Poly3DCollection(deformed[faces], array=risen, cmap="viridis", edgecolors="0.5", linewidths=0.15)
    skin.set_clip_on(False)  # the axes are a square, the drawing is wider
    axes.add_collection3d(skin)
    axes.computed_zorder = False  # tools in front of the stack, which would hide thin lines
    low, high = deformed.min(axis=0), deformed.max(axis=0)
    top = 2 * high[2] - low[2]
    for tool, tip in zip(scene.tool, tips, strict=False):
        outline = MM * (tool.section() + tip[[0, 2]])
        outline = outline[outline[:, 1] <= top]
        for y in np.clip(MM * (tip[1] + np.array(tool.reach[1])), low[1], high[1]):
            axes.plot(outline[:, 0], np.full(len(outline), y), outline[:, 1], color="black", zorder=2, clip_on=False)
        high[2], high[:1] = max(high[2], outline[:, 1].max()), max(high[0], outline[:, 0].max())
        low[0] = min(low[0], outline[:, 0].min())
    extent = np.maximum(high - low, 1e-9 * (high - low).max())
    flat = extent[:2].max() / extent[2]
    exaggeration = next((scale for scale in SCALES if scale >= LOWEST * flat), SCALES[-1])
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(extent * [1, 1, exaggeration], zoom=1.7)
    axes.view_init(elev=18, azim=-70)
    axes.locator_params(axis="y", nbins=3)
    axes.locator_params(axis="z", nbins=3)
    axes.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="height (mm)")
    axes.set_title(f"Seen from the side at the end, {scale_in_words(exaggeration)}")
    return skin


def _outside(mesh: meshio.Mesh) -> NDArray[np.int64]:
    """Corners of the top face and of the outer sides, shape (faces, 4)."""
    faces = mesh.cells_dict["hexahedron"][:, FACES].reshape(-1, 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    alone = faces[first[count == 1]]
    height, slack = mesh.points[alone][:, :, 2], 1e-9 * np.ptp(mesh.points)
    shown: NDArray[np.int64] = alone[(np.ptp(height, axis=1) > slack) | (height.min(axis=1) >= height.max() - slack)]
    return shown
