"""Tools against the mesh they meet, before a run: paths that leave the stack, elements too long for a tool's radius."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.kinds import numbered
from ncf_fenicsx.mesh.hexahedra import FACES, TAGS, Hexahedra
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface, Tool

Floats = NDArray[np.float64]

ELEMENTS_A_RADIUS = 3
"""Elements that a radius needs along its curve, for the contact to have more than a node or two."""
AXES = "xy"


def placement_cautions(scene: Scene, stack: Hexahedra) -> list[str]:
    """What is doubtful about where a scene's tools are, each with the number that would do."""
    named = [(numbered("tool", number), tool) for number, tool in enumerate(scene.tool)]
    cautions = [words for name, tool in named for words in _off_the_stack(name, tool, stack)]
    surfaces: list[tuple[str, RigidSurface]] = [*named]
    if scene.mould is not None:
        surfaces.append(("mould", scene.mould))
    return cautions + [words for name, surface in surfaces for words in _too_coarse(name, surface, stack)]


def _off_the_stack(name: str, tool: Tool, stack: Hexahedra) -> list[str]:
    low, high = stack.points.min(axis=0), stack.points.max(axis=0)
    for time in (0.0, *motion.milestones(tool.path)):
        tip = tool.tip(high[2], time)
        for axis, letter in enumerate(AXES):
            if not low[axis] - 1e-9 <= tip[axis] <= high[axis] + 1e-9:
                limits = f"{1e3 * low[axis]:.4g} to {1e3 * high[axis]:.4g} mm"
                where = f"{letter} = {1e3 * tip[axis]:.4g} mm"
                return [f"{name}.path: at {time:.4g} s the tip is at {where}, off the stack; expected {limits}"]
    return []


def _too_coarse(name: str, surface: RigidSurface, stack: Hexahedra) -> list[str]:
    """Elements of the pressed face, where the surface comes, against its radii."""
    tag = TAGS["bottom" if isinstance(surface, Mould) else "top"]
    quads = stack.points[stack.cells[:, FACES].reshape(-1, 4)[(stack.face_tags == tag).ravel()]]
    near = quads[reached(surface, quads)]
    cautions = []
    for axis, letter in enumerate(AXES):
        radius = surface.radii[axis]
        longest = float(np.ptp(near[:, :, axis], axis=1).max(initial=0.0))
        if radius is not None and longest > radius / ELEMENTS_A_RADIUS * (1 + 1e-9):
            finer = math.ceil(ELEMENTS_A_RADIUS * longest / radius * 10) / 10
            allowed = f"{1e3 * radius / ELEMENTS_A_RADIUS:.3g} mm, a third of its radius"
            cautions.append(
                f"stack.divisions: elements under {name} are up to {1e3 * longest:.3g} mm long along {letter}; "
                f"expected at most {allowed}: {finer:.3g} times as many"
            )
    return cautions


def reached(surface: RigidSurface, quads: Floats) -> NDArray[np.bool_]:
    """Which quads the surface's tip is over on its way, or within a radius of; along an axis without a radius, all."""
    tips = stops(surface)
    inside = np.ones(len(quads), dtype=bool)
    for axis in (0, 1):
        radius = surface.radii[axis]
        if radius is not None:
            along, first, last = quads[:, :, axis], tips[:, axis].min(), tips[:, axis].max()
            near = (along.mean(axis=1) >= first - radius) & (along.mean(axis=1) <= last + radius)
            inside &= near | ((along.min(axis=1) <= last) & (along.max(axis=1) >= first))
    return inside


def stops(surface: RigidSurface) -> Floats:
    """X and y (m) of the surface's tip at the start and at the end of each piece of its path, shape (stops, 2)."""
    if not isinstance(surface, Tool):
        return np.array([surface.position])
    return np.array([surface.tip(0.0, time)[:2] for time in (0.0, *motion.milestones(surface.path))])
