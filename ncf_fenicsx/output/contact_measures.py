"""What is measured of contacts and of the faces between layers, in each accepted state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.contact.layer_contact import LayerContact
from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.faces import SharedFace
from ncf_fenicsx.output.contact_edges import extent
from ncf_fenicsx.output.face_waves import FaceWaves, LayerFace, mould_columns, numbered_by_layer
from ncf_fenicsx.output.mould_void import OPEN, VOID_COLUMNS, MouldVoid
from ncf_fenicsx.output.symmetry import WholeFace
from ncf_fenicsx.output.voids import contact_extent, voids
from ncf_fenicsx.output.wrinkles import grid_of
from ncf_fenicsx.parameters.kinds import numbered

Floats = NDArray[np.float64]

RIGID_COLUMNS = {
    "pressure_max": ("Pa", "largest contact pressure at a node, per current area"),
    "contact_width": (
        "m",
        "extent of the contact along x, of the whole, between edges that the gaps show",
    ),
    "contact_length": ("m", "extent of the contact along y, of the whole, in the same way"),
    "penetration_max": ("m", "deepest penetration of a node"),
}
OPENING_COLUMNS = {
    **VOID_COLUMNS,
    "slip_max": ("m", "largest slip of the two faces along each other since the start"),
    "interface_pressure_max": ("Pa", "largest contact pressure at a node, per current area"),
    "interface_penetration_max": ("m", "deepest penetration of a node"),
}


class ContactMeasures:
    """Evaluates the contacts of a problem.

    Args:
        problem: what is measured.

    Attributes:
        waves: of the faces of layers.
        nodes: ``contact_pressure`` (Pa, per current area), ``gap`` (m, between layers) and ``slip`` (m) at this rank's
            local nodes in the last observed state, of which a scene has what it names.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        area_vector = problem.material.kinematics(problem.displacement).area_vector
        self.rigid = [_RigidFace(contact, area_vector, problem) for contact in problem.contacts.rigid]
        self.layers = [_LowerFace(contact, area_vector) for contact in problem.contacts.layers]
        self.waves = FaceWaves(problem)
        self._mould_void: MouldVoid | None = None
        if problem.contacts.mould is not None and self.waves.lower is not None:
            self._mould_void = MouldVoid(problem.contacts.mould, self.waves.lower, area_vector, problem)
        self._contact_of = {
            face.layer: layer for layer in self.layers for face in layer.contact.pairing.interfaces
        }  # of those that may open
        self.nodes: dict[str, Floats] = {}

    def observe(self) -> dict[str, float]:
        """Columns of the history in the trial state; keeps the fields at nodes."""
        self._fields()
        tools = len(self.problem.contacts.tools)
        row: dict[str, float] = {}
        for number, rigid in enumerate(self.rigid):
            values = dict(zip(RIGID_COLUMNS, rigid.columns(), strict=True))
            of_tool = {numbered(name, number): value for name, value in values.items()}
            row |= of_tool if number < tools else mould_columns(values)
        waves = self.waves.observe()
        for layer, face in enumerate(self.waves.upper):
            opening = self._opening(face, self._contact_of[layer]) if layer in self._contact_of else {}
            row |= numbered_by_layer(opening | waves[layer], layer)
        if self._mould_void is not None:
            row |= mould_columns(self._mould_void.observe() | waves[-1])
        return row

    def _fields(self) -> None:
        pressures = [rigid.observe() for rigid in self.rigid] + [layer.observe() for layer in self.layers]
        self.nodes = {"contact_pressure": np.sum(pressures, axis=0)} if pressures else {}
        if self.layers:
            self.nodes["gap"] = np.sum([layer.contact.gaps() for layer in self.layers], axis=0)
            slips = [np.linalg.norm(layer.contact.slipped(), axis=1) for layer in self.layers]
            self.nodes["slip"] = np.sum(slips, axis=0)

    def _opening(self, face: LayerFace, layer: _LowerFace) -> dict[str, float]:
        """Values of `OPENING_COLUMNS`."""
        fields = (self.nodes["gap"], layer.contact.face.area, self.nodes["slip"], layer.pressure)
        gap, area, slip, pressure = map(face.gather, fields)
        open_ = voids(face.undeformed[:, :2], face.whole.quads, gap, area, OPEN * self.problem.scales.length)
        # a node on a symmetry plane has but a part of its share in the model
        volume = self.problem.scene.stack.sides.copies * float(face.shared.gather(layer.opened_volume()).sum())
        deepest = float((-gap).max(initial=0.0))
        values = [open_.widest_opening, volume, open_.longest, float(slip.max()), float(pressure.max()), deepest]
        return dict(zip(OPENING_COLUMNS, values, strict=True))


class _CurrentArea:
    """Pressure per current area at the nodes of a face."""

    def __init__(self, contact: RigidContact | LayerContact, area_vector: Any) -> None:
        self.face, self._pressure_form = contact.face, contact.pressure_form
        self._area_form = contact.face.density(area_vector)

    def pressure(self) -> Floats:
        """Force over current area at this rank's local nodes in Pa; 0 off the face."""
        force, area = self.face.assembled(self._pressure_form), self.face.assembled(self._area_form)
        size = np.linalg.norm(area, axis=1)
        return np.divide(force, size, out=np.zeros_like(force), where=size > 0)


class _RigidFace:
    """Measures of the contact with one rigid surface."""

    def __init__(self, contact: RigidContact, area_vector: Any, problem: Problem) -> None:
        self.contact, self.problem = contact, problem
        self._current = _CurrentArea(contact, area_vector)
        self._shared = SharedFace(problem.contacts.body.spaces, contact.face.facets)
        self._whole = WholeFace(self._shared.undeformed, self._shared.quads, problem.scene.stack.sides)
        self._pressure: Floats = np.zeros(0)

    def observe(self) -> Floats:
        """Pressure per current area at this rank's local nodes in Pa."""
        self._pressure = self._current.pressure()
        return self._pressure

    def columns(self) -> list[float]:
        """Values of `RIGID_COLUMNS`."""
        shared, whole = self._shared, self._whole
        gap = shared.gather(self.contact.gaps())
        positions = shared.undeformed + shared.gather(self.problem.displacement.x.array.reshape(-1, 3))
        width, length = self._extent(whole.positions(positions)[:, :2], gap[whole.source])
        deepest = float((-gap).max(initial=0.0))
        return [float(shared.gather(self._pressure).max(initial=0.0)), width, length, deepest]

    def _extent(self, positions: Floats, gap: Floats) -> tuple[float, float]:
        """Extent of the contact in m along x and y: on the lines of a grid; half-way to the next nodes on other meshes.

        Args:
            positions: current positions of the nodes of the whole in plan in m, shape (nodes, 2).
            gap: at each of them in m.
        """
        grid = grid_of(self._whole.positions(self._shared.undeformed)[:, :2])
        if grid.nodes.shape[-1] > 1:
            return contact_extent(positions, self._whole.quads, np.where(gap > 0, 1.0, -1.0))
        nodes = grid.nodes[:, :, 0]
        along_x = extent(positions[nodes, 0], gap[nodes])
        return along_x, extent(positions[nodes.T, 1], gap[nodes.T])


class _LowerFace:
    """Measures of the contacts between layers of one kind."""

    def __init__(self, contact: LayerContact, area_vector: Any) -> None:
        self.contact = contact
        self._current = _CurrentArea(contact, area_vector)
        self.pressure: Floats = np.zeros(0)

    def observe(self) -> Floats:
        """Pressure per current area at this rank's local nodes in Pa."""
        self.pressure = self._current.pressure()
        return self.pressure

    def opened_volume(self) -> Floats:
        """Share of each local node in the volume of the openings in m3, of the modelled part."""
        volume: Floats = np.maximum(self.contact.gaps(), 0.0) * self.contact.face.area
        return volume
