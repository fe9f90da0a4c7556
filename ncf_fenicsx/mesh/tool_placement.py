"""Tools against the mesh they meet, before a run: where they are, whether they meet, elements too long for a radius."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.hexahedra import FACES, TAGS, Hexahedra
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.stack import Stack
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface, Tool

Floats = NDArray[np.float64]

ELEMENTS_A_RADIUS = 3
"""Elements that a radius needs along its curve, for the contact to have more than a node or two."""
AXES = "xy"
NEAR = 1e-9
"""Length in m that is none: round-off of positions."""


def position_of_tools(settings: Stack, stack: Hexahedra) -> tuple[float, float]:
    """Position (x, y) in m of tools that have none of their own.

    That of an extruded stack is its corner. A mesh file may lie anywhere: along each axis that is its plane of
    symmetry, or its middle where it has none.
    """
    if settings.mesh is None:
        return 0.0, 0.0
    low, high = stack.points.min(axis=0), stack.points.max(axis=0)
    sides = dict(settings.sides)
    position = (low + high) / 2
    for axis, letter in enumerate(AXES):
        if "symmetry" in (sides[f"{letter}_min"], sides[f"{letter}_max"]):
            position[axis] = low[axis] if sides[f"{letter}_min"] == "symmetry" else high[axis]
    return float(position[0]), float(position[1])


def check_placement(scene: Scene, stack: Hexahedra) -> None:
    """Refuse a tool that never meets the stack, or that goes through the plane that the stack lies on.

    Raises:
        SceneError: where the tool and the stack are.
    """
    low, high = stack.points.min(axis=0), stack.points.max(axis=0)
    on_plane = scene.mould is None and scene.stack.sides.bottom == "plane"
    for number, tool in enumerate(scene.tool):
        name, tips = numbered("tool", number), _tips(tool, high[2])
        if on_plane and not tool.under_force:
            _check_above(name, tips, low, high)
        for axis, letter in enumerate(AXES):
            first, last = tips[:, axis].min() + tool.reach[axis][0], tips[:, axis].max() + tool.reach[axis][1]
            if last < low[axis] - NEAR or first > high[axis] + NEAR:
                raise SceneError(
                    f"{name}.position: on its path the tool is over {_range(letter, first, last)}, the stack lies at "
                    f"{_range(letter, low[axis], high[axis])}: they never meet; expected a tool over the stack"
                )


def _check_above(name: str, tips: Floats, low: Floats, high: Floats) -> None:
    """Refuse tips that go down to the rigid plane under the stack: contact by penalty would let them through.

    A mould may lie deeper than the stack does at first, and a tool under force has no height of its own.

    Args:
        name: of the tool.
        tips: where its path bends in m, shape (positions, 3).
        low: lowest coordinates of the stack in m.
        high: the highest ones.
    """
    over = np.all((tips[:, :2] >= low[:2] - NEAR) & (tips[:, :2] <= high[:2] + NEAR), axis=1)
    lowest = float(tips[over, 2].min(initial=high[2]))
    if lowest <= low[2] + NEAR:
        raise SceneError(
            f"{name}.path: its lowest tip is at z = {_millimetres(lowest)} mm, the rigid plane under the stack at "
            f"{_millimetres(float(low[2]))} mm; expected a path that stays above it"
        )


def _range(letter: str, first: float, last: float) -> str:
    return f"{letter} = {_millimetres(first)} to {_millimetres(last)} mm"


def _millimetres(length: float) -> str:
    return f"{round(1e3 * length, 9) + 0.0:.4g}"


def _tips(tool: Tool, top: float) -> Floats:
    """Positions of a tool's tip (m) where its path bends, shape (positions, 3); in between it goes straight."""
    return np.array([tool.tip(top, time) for time in (0.0, *motion.milestones(tool.path))])


def placement_cautions(scene: Scene, stack: Hexahedra) -> list[str]:
    """What is doubtful about where a scene's tools are, each with the number that would do."""
    named = [(numbered("tool", number), tool) for number, tool in enumerate(scene.tool)]
    cautions = [words for name, tool in named for words in _off_the_stack(name, tool, stack)]
    cautions += [words for name, tool in named for words in _too_high(name, tool, stack)]
    cautions += [words for name, tool in named for words in _mirrored(name, tool, scene.stack, stack)]
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


def _too_high(name: str, tool: Tool, stack: Hexahedra) -> list[str]:
    """A tool may wait there for fabric that rises, but hardly does."""
    top = float(stack.points[:, 2].max())
    lowest = float(_tips(tool, top)[:, 2].min())
    if tool.under_force or lowest <= top + NEAR:
        return []
    return [
        f"{name}.path: its lowest tip is at z = {_millimetres(lowest)} mm, the top of the stack at "
        f"{_millimetres(top)} mm: they never meet unless the stack rises; expected a path that goes lower"
    ]


def _mirrored(name: str, tool: Tool, settings: Stack, stack: Hexahedra) -> list[str]:
    """Planes of symmetry that the tool is beside, not on: there is one more of it behind each.

    Along an axis that a tool covers the whole stack, its images go on where it ends.
    """
    low, high = stack.points.min(axis=0), stack.points.max(axis=0)
    tips = _tips(tool, high[2])
    beside = []
    for side in (side for side, way in settings.sides if way == "symmetry"):
        axis = AXES.index(side[0])
        covers = tips[:, axis].max() + tool.reach[axis][0] <= low[axis] + NEAR
        covers &= tips[:, axis].min() + tool.reach[axis][1] >= high[axis] - NEAR
        plane = low[axis] if side.endswith("min") else high[axis]
        if not covers and np.abs(tips[:, axis] - plane).max() > NEAR:
            beside.append(side)
    if not beside:
        return []
    planes = f"plane{'s' if len(beside) > 1 else ''} of symmetry {' and '.join(beside)}"
    return [
        f"{name}.position: it is beside the {planes}, so its images press too: "
        f"{name.replace('tool', 'tool_force')} is that of {2 ** len(beside)} tools"
    ]


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
    return _tips(surface, 0.0)[:, :2]
