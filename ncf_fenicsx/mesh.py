"""Scene to distributed, tagged mesh: an extruded stack, or a gmsh file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

from ncf_fenicsx import compat, hexahedra
from ncf_fenicsx.gmsh_file import read_gmsh
from ncf_fenicsx.hexahedra import TAGS, Hexahedra, Integers
from ncf_fenicsx.parallel import on_root
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene_errors import SceneError
from ncf_fenicsx.scene_stack import Bonded, Stack


@dataclass(frozen=True)
class StackMesh:
    """A distributed stack of layers.

    Attributes:
        mesh: DOLFINx mesh; whole columns of cells stand on one rank, and there are no ghost cells.
        layer: layer of each local cell, 0 at the bottom.
        facet_tags: DOLFINx tags of the facets, numbered as in ``TAGS``.
        interface_nodes: number of node pairs between layers over all ranks.
        top: height of the undeformed stack's top in m.
        extent: largest of its extents along the axes in m.
    """

    mesh: Any
    layer: Integers
    facet_tags: Any
    interface_nodes: int
    top: float
    extent: float

    def facets(self, name: str) -> Integers:
        """Local facets with a tag."""
        return self.facet_tags.find(TAGS[name])


def build_mesh(scene: Scene, comm: MPI.Comm) -> StackMesh:
    """Mesh of a scene's stack on all ranks.

    Raises:
        SceneError: an untagged cell or facet, a missing or unknown name, an inverted or degenerate cell.
    """
    stack = on_root(comm, lambda: stack_of(scene))
    parts = hexahedra.columns(stack, comm.size)
    held = slice(None) if comm.rank == 0 else slice(0)  # rank 0 hands the cells out
    mesh = compat.create_hexahedral_mesh(comm, stack.cells[held], stack.points[held], parts[held])
    origin = mesh.topology.original_cell_index
    return StackMesh(
        mesh=mesh,
        layer=stack.layer[origin],
        facet_tags=_facet_tags(mesh, stack.face_tags[origin]),
        interface_nodes=_interface_nodes(stack),
        top=float(stack.points[:, 2].max()),
        extent=float(np.ptp(stack.points, axis=0).max()),
    )


def stack_of(scene: Scene) -> Hexahedra:
    """The checked stack of a scene as plain arrays, its layers bonded or with nodes of their own."""
    file = scene.stack.mesh
    stack = _extruded(scene) if file is None else read_gmsh(Path(file), scene.stack.layers)
    hexahedra.check_cells(stack)
    _check_sides(scene.stack, stack)
    bonded = isinstance(scene.interface, Bonded)
    stack = hexahedra.mark_interfaces(hexahedra.bond_layers(stack) if bonded else hexahedra.split_layers(stack))
    _check_thickness(scene.stack, stack)
    if scene.laws.bending is not None:
        _check_mid_planes(scene.stack, stack)
    return stack


def _extruded(scene: Scene) -> Hexahedra:
    stack = scene.stack
    focus = stack.focus or (scene.tool.position if scene.tool is not None else (0.0, 0.0))
    x, y = (
        hexahedra.graded(stack.divisions[axis], stack.size[axis], focus[axis], stack.grading[axis]) for axis in (0, 1)
    )
    heights = [
        stack.thickness * np.linspace(number, number + 1, elements + 1)
        for number, elements in enumerate(stack.elements_through)
    ]
    return hexahedra.extrude(x, y, heights)


def _check_sides(settings: Stack, stack: Hexahedra) -> None:
    held = [name for name, side in settings.sides if side != "free"]
    for name in ["bottom", "top", *held]:
        if not np.any(stack.face_tags == TAGS[name]):
            raise SceneError(f"mesh: no facets named {name!r}; expected them, the scene holds or presses that face")


def _check_thickness(settings: Stack, stack: Hexahedra) -> None:
    """Vf0, weight and contact stiffness come from the scene's thickness: the mesh must have it, on a flat bottom."""
    quads = stack.points[stack.cells[:, hexahedra.FACES].reshape(-1, 4)]
    bottom = quads[(stack.face_tags == TAGS["bottom"]).ravel()]
    if np.ptp(bottom[:, :, 2]) > 1e-3 * settings.thickness:
        raise SceneError("mesh: the bottom is not flat; expected a stack on a plane at one height z")
    area = np.abs(np.cross(bottom[:, 1] - bottom[:, 0], bottom[:, 2] - bottom[:, 0])[:, 2]).sum()
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


def _facet_tags(mesh: Any, face_tags: Integers) -> Any:
    topology = mesh.topology
    topology.create_connectivity(3, 2)
    topology.create_connectivity(2, 3)
    facets = topology.connectivity(3, 2).array.reshape(-1, 6)[: len(face_tags)]
    tagged = face_tags != hexahedra.NO_TAG
    entities, first = np.unique(facets[tagged], return_index=True)
    values = face_tags[tagged][first].astype(np.int32)
    return dolfinx.mesh.meshtags(mesh, 2, entities.astype(np.int32), values)


def _interface_nodes(stack: Hexahedra) -> int:
    """Number of distinct nodes on the lower layers' faces at all interfaces."""
    cell, face = np.nonzero(stack.face_tags == TAGS["lower"])
    return len(np.unique(stack.cells[cell[:, None], hexahedra.FACES[face]]))
