"""How large a stack's mesh will be and where tools meet it, from the numbers of a scene: nothing is built.

Only a mesh file is read, as it says by itself what it holds. An extruded stack is products of grid lines, so its size
is counted, and where tools come is judged on a few of its cells: those that decide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh import hexahedra
from ncf_fenicsx.mesh.elements import Element
from ncf_fenicsx.mesh.hexahedra import FACES, NO_TAG, TAGS, Floats, Hexahedra, Integers, lower_tag
from ncf_fenicsx.mesh.stack_mesh import focus_of, grid_lines, stack_of
from ncf_fenicsx.mesh.tool_placement import check_placement, placement_cautions, position_of_tools, reached, stops
from ncf_fenicsx.mesh.wave_resolution import wave_cautions
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import Bonded
from ncf_fenicsx.scene.stack import Stack
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface
from ncf_fenicsx.tools.start import check_depth, depth_at_start, distances

EVERY = 60
"""Elements along an axis up to which all are looked at; of more, as many and those that decide."""
MOST = 200_000
"""Grid lines that are worked out along an axis; elements are taken for that long where there are more of them."""
FAR = 1e6
"""Length in m that is beyond every stack."""


@dataclass(frozen=True)
class StackSize:
    """What a mesh will consist of.

    Attributes:
        cells: number of hexahedra.
        nodes: number of nodes.
        facing: number of facets where layers may part, of the lower layer of each two.
        cautions: what is doubtful about where the tools are, and about elements.
        position: of tools that have none of their own, x and y in m.
    """

    cells: int
    nodes: int
    facing: int
    cautions: list[str]
    position: tuple[float, float]

    @property
    def unknowns(self) -> int:
        """Number of displacements: three at each node."""
        return 3 * self.nodes


def size_of(scene: Scene) -> StackSize:
    """Size of a scene's stack, and cautions on its tools.

    Raises:
        SceneError: the mesh file is not valid, the mesh could not be built, or a tool starts in the stack or never
            meets it.
    """
    if scene.stack.mesh is not None:
        stack = stack_of(scene)
        cells, nodes, facing = _of_arrays(scene, stack)
    else:
        _check_bonds(scene)
        _check_lengths(scene)
        cells, nodes, facing = _counted(scene)
        stack = _few_cells(scene)
    position = position_of_tools(scene.stack, stack)
    placed = scene.with_tools_over(position)
    check_placement(placed, stack)
    _check_start(placed, stack)
    return StackSize(
        cells, nodes, facing, [*placement_cautions(placed, stack), *wave_cautions(placed, stack)], position
    )


def _of_arrays(scene: Scene, stack: Hexahedra) -> tuple[int, int, int]:
    """Cells, nodes and facing facets of a stack that is there."""
    nodes = int(hexahedra.between(stack, Element(scene.stack.order).vertices).max()) + 1
    parting = [lower_tag(layer) for layer, way in enumerate(scene.interfaces) if not isinstance(way, Bonded)]
    return len(stack.cells), nodes, int(np.isin(stack.face_tags, parting).sum())


def _counted(scene: Scene) -> tuple[int, int, int]:
    """The same of an extruded stack, by counting: bonded layers share the nodes where they meet."""
    settings = scene.stack
    plan = [x * y for x, y in settings.divisions_by_layer]
    level = [(settings.order * x + 1) * (settings.order * y + 1) for x, y in settings.divisions_by_layer]
    through = settings.elements_through
    bonded = [isinstance(way, Bonded) for way in scene.interfaces]
    cells = sum(elements * count for elements, count in zip(through, plan, strict=True))
    nodes = sum((elements + 1) * count for elements, count in zip(through, level, strict=True))
    shared = sum(count for count, bond in zip(level, bonded, strict=False) if bond)
    facing = sum(count for count, bond in zip(plan, bonded, strict=False) if not bond)
    return cells, nodes - shared, facing


def _check_bonds(scene: Scene) -> None:
    """Bonded layers of an extruded stack match where their divisions are the same."""
    divisions = scene.stack.divisions_by_layer
    for layer, way in enumerate(scene.interfaces):
        if isinstance(way, Bonded) and divisions[layer] != divisions[layer + 1]:
            raise SceneError(f"mesh: layers {layer + 1} and {layer + 2} are bonded; expected facets that match")


def _check_lengths(scene: Scene) -> None:
    """Elements of an extruded stack are boxes: those with the shortest and longest edges would be degenerate first."""
    settings, focus = scene.stack, focus_of(scene)
    heights = sorted({settings.thickness / elements for elements in settings.elements_through})
    for divisions in dict.fromkeys(settings.divisions_by_layer):
        edges = [np.diff(_lines(settings, focus, divisions, axis)) for axis in (0, 1)]
        ends = [(float(lengths.min()), float(lengths.max())) for lengths in edges]
        for box in ((x, y, z) for x in ends[0] for y in ends[1] for z in heights):
            if hexahedra.is_degenerate(np.prod(box), np.array(box)):
                shown = " x ".join(f"{1e3 * length:.4g}" for length in box)
                raise SceneError(f"mesh: cells of {shown} mm are degenerate; expected edges of a similar length")


def _lines(stack: Stack, focus: tuple[float, float], divisions: tuple[int, int], axis: int) -> Floats:
    """Coordinates in m of the element edges along an axis."""
    x, y = divisions
    return grid_lines(stack, focus, (min(x, MOST), min(y, MOST)), axis)


def _few_cells(scene: Scene) -> Hexahedra:
    """The cells of the outermost layers of an extruded stack that decide what is doubtful about tools and mould."""
    stack, focus = scene.stack, focus_of(scene)
    parts = []
    for layer, name in ((0, "bottom"), (stack.layers - 1, "top")):
        divisions = stack.divisions_by_layer[layer]
        surfaces = [surface for surface in scene.rigid_surfaces if isinstance(surface, Mould) == (name == "bottom")]
        x, y = (_deciding(_lines(stack, focus, divisions, axis), surfaces, axis) for axis in (0, 1))
        base, height = layer * stack.thickness, stack.thickness / stack.elements_through[layer]
        low = base if name == "bottom" else base + stack.thickness - height
        parts.append(_boxes(x, y, np.array([low, low + height]), name, layer))
    offset = len(parts[0].points)
    return Hexahedra(
        points=np.concatenate([part.points for part in parts]),
        cells=np.concatenate([parts[0].cells, parts[1].cells + offset]),
        layer=np.concatenate([part.layer for part in parts]),
        face_tags=np.concatenate([part.face_tags for part in parts]),
    )


def _deciding(lines: Floats, surfaces: list[RigidSurface], axis: int) -> Floats:
    """Ends in m of elements along an axis, shape (elements, 2): some all over, and for each surface those that decide.

    Of those that it reaches, these are the first, the last and the longest; and the nearest ones at each of its stops.
    """
    edges = np.stack([lines[:-1], lines[1:]], axis=1)
    last = len(edges) - 1
    chosen = {round(float(number)) for number in np.linspace(0, last, min(len(edges), EVERY))}
    for surface in surfaces:
        strips = np.zeros((len(edges), 2, 3))
        strips[:, :, axis], strips[:, :, 1 - axis] = edges, (-FAR, FAR)
        within = np.flatnonzero(reached(surface, strips))
        if len(within):
            longest = within[np.argmax(edges[within, 1] - edges[within, 0])]
            chosen |= {int(number) for number in (within[0], within[-1], longest)}
        for tip in stops(surface)[:, axis]:
            nearest = int(np.searchsorted(lines, tip))
            chosen |= {min(max(number, 0), last) for number in (nearest - 1, nearest)}
    return edges[sorted(chosen)]


def _boxes(x: Floats, y: Floats, z: Floats, name: str, layer: int) -> Hexahedra:
    """Separate boxes between ends in m along x and y, shapes (elements, 2), and two heights; one face has a name."""
    corners = np.empty((len(y), len(x), 2, 2, 2, 3))
    corners[..., 0] = x[None, :, None, None, :]
    corners[..., 1] = y[:, None, None, :, None]
    corners[..., 2] = z[:, None, None]
    points = corners.reshape(-1, 3)
    cells: Integers = np.arange(len(points)).reshape(-1, 8)
    tags = np.full((len(cells), 6), NO_TAG)
    tags[:, 0 if name == "bottom" else 5] = TAGS[name]
    return Hexahedra(points, cells, np.full(len(cells), layer), tags)


def _check_start(scene: Scene, stack: Hexahedra) -> None:
    """Whether a rigid surface starts in the stack, by its distance from the nodes of the face that it meets."""
    heights = stack.points[:, 2]
    named: list[tuple[str, RigidSurface, Floats]] = [
        (numbered("tool", number), tool, tool.tip(float(heights.max()), 0.0)) for number, tool in enumerate(scene.tool)
    ]
    if scene.mould is not None:
        named.append(("mould", scene.mould, scene.mould.tip(float(heights.min()))))
    for name, surface, tip in named:
        nodes = _nodes(stack, "bottom" if isinstance(surface, Mould) else "top", scene.stack.order)
        depth = depth_at_start(
            surface,
            tip,
            lambda at, nodes=nodes, surface=surface: float(distances(surface, nodes - at).min()),  # type: ignore[misc]
            1e-6 * scene.stack.thickness,
        )
        check_depth(name, surface, depth)


def _nodes(stack: Hexahedra, name: str, order: int) -> Floats:
    """Nodes in m of the faces with a name: their corners, and with order 2 what is between them."""
    quads = stack.points[stack.cells[:, FACES].reshape(-1, 4)[(stack.face_tags == TAGS[name]).ravel()]]
    corners = quads.reshape(-1, 2, 2, 3)
    if order > 1:
        along = np.stack([corners[:, :, 0], corners.mean(axis=2), corners[:, :, 1]], axis=2)
        corners = np.stack([along[:, 0], along.mean(axis=1), along[:, 1]], axis=1)
    nodes: Floats = np.unique(corners.reshape(-1, 3), axis=0)
    return nodes
