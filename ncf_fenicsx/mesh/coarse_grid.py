"""The mesh of a coarse run: as fine as a tool's radius asks for, and no finer than its path asks for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mesh.equidistribution import SAMPLES, with_lengths
from ncf_fenicsx.mesh.tool_placement import AXES, ELEMENTS_A_RADIUS, stops
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.tools.rigid_surface import ENDLESS, RigidSurface

Floats = NDArray[np.float64]

LEAST = 4
"""Elements along an axis on which something may vary."""


def coarse_scene(scene: Scene) -> Scene:
    """The scene on the mesh of a coarse run.

    Within a radius of where a surface's tip comes, elements are as long as its radius can be followed by; where a
    surface ends, they are as long as a layer is thick. From there they grow.

    Args:
        scene: the case; its stack is extruded.
    """
    return on_nodes(scene, _along(scene, 0), _along(scene, 1))


def on_nodes(scene: Scene, x: Floats, y: Floats) -> Scene:
    """The scene with nodes at x and y in m, to the nanometre, in place of divisions."""
    stack = scene.stack.with_nodes((tuple(map(float, x.round(9))), tuple(map(float, y.round(9)))))
    return scene.model_copy(update={"stack": stack})


def _along(scene: Scene, axis: int) -> Floats:
    size = scene.stack.size[axis]
    points: Floats = np.linspace(0.0, size, SAMPLES + 1, dtype=np.float64)
    middles = (points[1:] + points[:-1]) / 2
    lengths: Floats = np.full(SAMPLES, size / (LEAST if _may_vary(scene, axis) else 1))
    for surface in scene.rigid_surfaces:
        radius, tips = surface.radii[axis], stops(surface)[:, axis]
        if radius is not None:
            near = (middles >= tips.min() - radius) & (middles <= tips.max() + radius)
            lengths[near] = np.minimum(lengths[near], radius / ELEMENTS_A_RADIUS)
        for end in _ends(surface, tips, axis):
            if 0 <= end <= size:
                nearest = min(int(SAMPLES * end / size), SAMPLES - 1)
                lengths[nearest] = min(lengths[nearest], scene.stack.thickness)
    return with_lengths(points, lengths)


def _may_vary(scene: Scene, axis: int) -> bool:
    """Whether anything ends along an axis: the fabric, or a surface."""
    sides = dict(scene.stack.sides)
    ends = {sides[f"{AXES[axis]}_min"], sides[f"{AXES[axis]}_max"]} != {"symmetry"}
    return ends or any(surface.reach[axis] != ENDLESS or surface.radii[axis] for surface in scene.rigid_surfaces)


def _ends(surface: RigidSurface, tips: Floats, axis: int) -> tuple[float, float]:
    """Where along an axis a surface that moves over its stops begins and ends."""
    first, last = surface.reach[axis]
    return tips.min() + first, tips.max() + last
