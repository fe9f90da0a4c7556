"""Scene to distributed, tagged mesh: an extruded stack, or a mesh file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh import compat, hexahedra
from ncf_fenicsx.mesh.elements import Element
from ncf_fenicsx.mesh.hexahedra import TAGS, Hexahedra, Integers
from ncf_fenicsx.mesh.mesh_checks import check_extent, check_mesh
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.mesh.stack_file import read_stack
from ncf_fenicsx.mesh.tool_placement import check_placement, placement_cautions, position_of_tools
from ncf_fenicsx.mesh.wave_resolution import wave_cautions
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import Bonded
from ncf_fenicsx.scene.stack import Stack


@dataclass(frozen=True)
class StackMesh:
    """A distributed stack of layers.

    Attributes:
        mesh: DOLFINx mesh; whole columns of cells stand on one rank, and there are no ghost cells.
        element: of the displacement.
        numbers: number of each node of each local cell before the mesh was shared out among ranks, (cells, nodes).
        layer: layer of each local cell, 0 at the bottom.
        facet_tags: DOLFINx tags of the facets, numbered as in ``TAGS``.
        open_interfaces: layers (0 at the bottom) that meet the next one without sharing nodes.
        bottom: height of the undeformed stack's bottom in m.
        top: height of its top in m.
        extent: largest of its extents along the axes in m.
        cautions: what is doubtful about where the tools are, and about elements.
        position: x and y in m of tools that have no position of their own.
    """

    mesh: Any
    element: Element
    numbers: Integers
    layer: Integers
    facet_tags: Any
    open_interfaces: list[int]
    bottom: float
    top: float
    extent: float
    cautions: list[str]
    position: tuple[float, float]

    @property
    def cell_numbers(self) -> Integers:
        """Number of each local cell before the mesh was shared out among ranks."""
        numbers: Integers = np.asarray(self.mesh.topology.original_cell_index, dtype=np.int64)
        return numbers

    def node_numbers(self, space: Any) -> Integers:
        """Number of each local node of a nodal space before the mesh was shared out among ranks."""
        index_map = space.dofmap.index_map
        numbers = np.empty(index_map.size_local + index_map.num_ghosts, dtype=np.int64)
        numbers[space.dofmap.list] = self.numbers
        return numbers

    def sublaminates(self, space: Any) -> Integers:
        """Number of the sublaminate, layers that share nodes, of each owned node of a nodal space, 0 at the bottom."""
        index_map = space.dofmap.index_map
        sublaminates = np.zeros(index_map.size_local + index_map.num_ghosts, dtype=np.int64)
        sublaminates[space.dofmap.list] = np.searchsorted(self.open_interfaces, self.layer)[:, None]
        return sublaminates[: index_map.size_local]

    def facets(self, tag: int | str) -> Integers:
        """Local facets with a tag, or its name."""
        return self.facet_tags.find(TAGS[tag] if isinstance(tag, str) else tag)


def build_mesh(scene: Scene, comm: MPI.Comm) -> StackMesh:
    """Mesh of a scene's stack on all ranks.

    Raises:
        SceneError: an untagged cell or facet, a missing or unknown name, an inverted or degenerate cell, a group that
            lies or faces elsewhere than its name says, a tool that never meets the stack.
    """
    stack = on_root(comm, lambda: stack_of(scene))
    position = position_of_tools(scene.stack, stack)
    placed = scene.with_tools_over(position)
    check_placement(placed, stack)
    parts = hexahedra.columns(stack, comm.size)
    held = slice(None) if comm.rank == 0 else slice(0)  # rank 0 hands the cells out
    mesh = compat.create_hexahedral_mesh(comm, stack.cells[held], stack.points[held], parts[held])
    origin, element = mesh.topology.original_cell_index, Element(scene.stack.order)
    return StackMesh(
        mesh=mesh,
        element=element,
        numbers=hexahedra.between(stack, element.vertices)[origin],
        layer=stack.layer[origin],
        facet_tags=_facet_tags(mesh, stack.face_tags[origin]),
        open_interfaces=[k for k, way in enumerate(scene.interfaces) if not isinstance(way, Bonded)],
        bottom=float(stack.points[:, 2].min()),
        top=float(stack.points[:, 2].max()),
        extent=float(np.ptp(stack.points, axis=0).max()),
        cautions=[*placement_cautions(placed, stack), *wave_cautions(placed, stack)],
        position=position,
    )


def stack_of(scene: Scene) -> Hexahedra:
    """The checked stack of a scene as plain arrays, its layers bonded or with nodes of their own."""
    file = scene.stack.mesh
    stack = _extruded(scene.stack, focus_of(scene)) if file is None else read_stack(Path(file), scene.stack.layers)
    if file is not None:
        check_extent(stack)
    hexahedra.check_cells(stack)
    _check_sides(scene.stack, stack)
    if file is not None:
        check_mesh(scene.stack, stack)
    bonded = [isinstance(way, Bonded) for way in scene.interfaces]
    sublaminate = np.cumsum([0, *(not shared for shared in bonded)])
    together = hexahedra.bond_layers(stack) if any(bonded) else stack
    stack = hexahedra.mark_interfaces(hexahedra.split_layers(together, sublaminate), sublaminate)
    _check_interfaces(scene.stack, stack, [layer for layer, shared in enumerate(bonded) if not shared])
    _check_thickness(scene.stack, stack)
    if scene.laws.bending is not None:
        _check_mid_planes(scene.stack, stack)
    if scene.stack.order > 1:
        _check_third_axes(stack)
    return stack


def focus_of(scene: Scene) -> tuple[float, float]:
    """X and y in m that the mesh of an extruded stack is refined towards."""
    return scene.stack.focus or (scene.tool[0].position if scene.tool else (0.0, 0.0))


def grid_lines(stack: Stack, focus: tuple[float, float], divisions: tuple[int, int], axis: int) -> hexahedra.Floats:
    """Coordinates in m of the element edges of an extruded stack along an axis.

    Args:
        stack: its settings.
        focus: x and y in m that elements are refined towards.
        divisions: elements along x and y.
        axis: 0 for x, 1 for y.
    """
    if stack.nodes is not None:
        return np.array(stack.nodes[axis])
    return hexahedra.graded(divisions[axis], stack.size[axis], focus[axis], stack.grading[axis])


def _extruded(stack: Stack, focus: tuple[float, float]) -> Hexahedra:
    grids = [[grid_lines(stack, focus, divisions, axis) for axis in (0, 1)] for divisions in stack.divisions_by_layer]
    heights = [
        stack.thickness * np.linspace(number, number + 1, elements + 1)
        for number, elements in enumerate(stack.elements_through)
    ]
    return hexahedra.extrude(grids, heights)


def _check_sides(settings: Stack, stack: Hexahedra) -> None:
    held = [name for name, side in settings.sides if side != "free"]
    for name in ["bottom", "top", *held]:
        if not np.any(stack.face_tags == TAGS[name]):
            raise SceneError(f"mesh: no facets named {name!r}; expected them, the scene holds or presses that face")


def _check_interfaces(settings: Stack, stack: Hexahedra, layers: list[int]) -> None:
    """Both faces of an interface have to cover the same part of the plane, and lie on each other."""
    for layer in layers:
        tags = (hexahedra.lower_tag(layer), hexahedra.upper_tag(layer))
        (area, height), (area_above, height_above) = (_plan_area(stack, stack.face_tags == tag) for tag in tags)
        meets = f"mesh: layer {layer + 1} meets layer {layer + 2}"
        if abs(area - area_above) > 0.01 * max(area, area_above):
            raise SceneError(
                f"{meets} with {1e6 * area:.4g} mm2 of facets without a tag, but that one with "
                f"{1e6 * area_above:.4g} mm2; expected the same"
            )
        if abs(height_above - height) > 0.05 * settings.thickness:
            raise SceneError(
                f"{meets} at a mean height of {1e3 * height:.4g} mm, but that one begins at "
                f"{1e3 * height_above:.4g} mm; expected layers that touch"
            )


def _plan_area(stack: Hexahedra, faces: NDArray[np.bool_]) -> tuple[float, float]:
    """Area in m2 that some of all cells' faces cover in plan, and their mean height in m over it."""
    quads = stack.points[stack.cells[:, hexahedra.FACES].reshape(-1, 4)[faces.ravel()]]
    areas = np.abs(np.cross(quads[:, 3] - quads[:, 0], quads[:, 2] - quads[:, 1])[:, 2]) / 2
    heights = quads[:, :, 2].mean(axis=1)
    return float(areas.sum()), float(areas @ heights / max(areas.sum(), np.finfo(float).tiny))


def _check_thickness(settings: Stack, stack: Hexahedra) -> None:
    """Vf0, weight and contact stiffness come from the scene's thickness: the mesh must have it, on a flat bottom."""
    quads = stack.points[stack.cells[:, hexahedra.FACES].reshape(-1, 4)]
    bottom = quads[(stack.face_tags == TAGS["bottom"]).ravel()]
    if np.ptp(bottom[:, :, 2]) > 1e-3 * settings.thickness:
        raise SceneError("mesh: the bottom is not flat; expected a stack on a plane at one height z")
    area, _ = _plan_area(stack, stack.face_tags == TAGS["bottom"])
    volume = np.bincount(stack.layer, hexahedra.corner_volumes(stack).mean(axis=1), settings.layers)
    for layer, thickness in enumerate(volume / area):
        if abs(thickness / settings.thickness - 1) > 0.02:
            raise SceneError(
                f"mesh: layer {layer + 1} is {1e3 * thickness:.4g} mm thick on average; "
                f"expected stack.thickness = {1e3 * settings.thickness:.4g} mm (a mesh's lengths are metres)"
            )


def _check_mid_planes(settings: Stack, stack: Hexahedra) -> None:
    """Bending is told apart at the mid-planes of elements, which have to be those of the layers."""
    corners = stack.points[stack.cells]
    height = (corners[:, 4:] - corners[:, :4])[:, :, 2].mean(axis=1)
    wrong = np.flatnonzero(height < 0.9 * settings.thickness)
    if len(wrong):
        raise SceneError(
            f"mesh: cell {wrong[0]} is {1e3 * height[wrong[0]]:.4g} mm high along its third axis; "
            f"expected one element through each layer of {1e3 * settings.thickness:.4g} mm with laws.bending"
        )


def _check_third_axes(stack: Hexahedra) -> None:
    """Elements of order 2 are so along their first two axes, which have to be those in the plane of the layers."""
    corners = stack.points[stack.cells].reshape(-1, 2, 2, 2, 3)
    edges = np.stack([np.diff(corners, axis=axis).mean(axis=(1, 2, 3)) for axis in (3, 2, 1)], axis=1)
    slopes = np.abs(edges[:, :, 2]) / np.linalg.norm(edges, axis=2)
    wrong = np.flatnonzero(np.argmax(slopes, axis=1) != 2)
    if len(wrong):
        where = hexahedra.point_in_words(stack.points[stack.cells[wrong[0]]].mean(axis=0))
        raise SceneError(
            f"mesh: cell {wrong[0]} at {where} lies on its side; "
            "expected cells with their third axis across the layers with stack.order = 2"
        )


def _facet_tags(mesh: Any, face_tags: Integers) -> Any:
    topology = mesh.topology
    topology.create_connectivity(3, 2)
    topology.create_connectivity(2, 3)
    facets = topology.connectivity(3, 2).array.reshape(-1, 6)[: len(face_tags)]
    tagged = face_tags != hexahedra.NO_TAG
    entities, first = np.unique(facets[tagged], return_index=True)
    values = face_tags[tagged][first].astype(np.int32)
    return dolfinx.mesh.meshtags(mesh, 2, entities.astype(np.int32), values)
