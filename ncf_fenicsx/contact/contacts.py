"""All contacts of a scene together: tools and mould on the outer faces, layers on each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import ufl
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.contact.force_control import ForceControl
from ncf_fenicsx.contact.held_contact import HeldLayers
from ncf_fenicsx.contact.layer_contact import LayerContact
from ncf_fenicsx.contact.multiplier import Multiplier
from ncf_fenicsx.contact.pairing import Pairing
from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.contact.tangent_blocks import Blocks
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.hexahedra import TAGS, lower_tag
from ncf_fenicsx.mesh.state_fields import StateField
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import OneSided
from ncf_fenicsx.tools.start import check_depth

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Contacts:
    """What a scene's fabric may touch; only what the scene names is built.

    Args:
        scene: the case.
        stack: its mesh.
        body: its fabric.
        area_vector: current normal of the layers times their area stretch.

    Attributes:
        tools: contacts with the tools, in the scene's order.
        mould: contact with the mould; None without one.
        layers: contacts between layers, equal interfaces together.
        controls: equations of the tools whose path names a force.
        pairings: how often layers were paired.
    """

    def __init__(self, scene: Scene, stack: StackMesh, body: DeformedBody, area_vector: Expression) -> None:
        self.body, tags, spaces = body, stack.facet_tags, body.spaces
        top = Face(spaces, tags, (TAGS["top"],)) if scene.tool else None
        self.tools = [
            RigidContact(numbered("tool", number), tool, top, body, stack.top)
            for number, tool in enumerate(scene.tool)
            if top is not None
        ]
        self.mould: RigidContact | None = None
        if scene.mould is not None:
            bottom = Face(spaces, tags, (TAGS["bottom"],))
            self.mould = RigidContact("mould", scene.mould, bottom, body, stack.bottom)
        self.layers: list[LayerContact] = []
        for number, (way, layers) in enumerate(_equal_interfaces(scene, stack)):
            face = Face(spaces, tags, tuple(lower_tag(layer) for layer in layers))
            pairing, name = Pairing(spaces, stack, layers), numbered("interface", number)
            self.layers.append(LayerContact(name, way, face, pairing, body, area_vector))
        forced = [tool for tool in self.tools if tool.surface.under_force]
        self.pairings, self._holding_tools = 0, False
        self._step_travel = scene.solver.step_travel * body.thickness
        self.controls = [ForceControl(tool, scene.stack.sides.copies) for tool in forced]

    @property
    def rigid(self) -> list[RigidContact]:
        """Contacts with tools and mould."""
        return [*self.tools, *([self.mould] if self.mould is not None else [])]

    @property
    def all(self) -> list[RigidContact | LayerContact]:
        """All contacts."""
        return [*self.rigid, *self.layers]

    @property
    def stiffness(self) -> float:
        """Largest contact stiffness in Pa/m that the scene gives, 0 without contact."""
        penalties = [surface.surface.penalty for surface in self.rigid] + [way.settings.penalty for way in self.layers]
        return max((penalty.resolve(self.body.natural_stiffness) for penalty in penalties), default=0.0)

    def terms(self) -> dict[str, ufl.Form]:
        """Virtual work (J) of each contact, by name."""
        return {contact.name: contact.term for contact in self.all}

    @property
    def state(self) -> list[StateField]:
        """All that the contacts remember."""
        fields = [field for contact in self.all for field in contact.state]
        return fields + [control.state for control in self.controls]

    def move_tools(self, time: float, size: float) -> None:
        """Put the tools where they are after a step from ``time`` by ``size`` (s)."""
        for surface in self.rigid:
            surface.move(time, size)

    def begin(self, time: float, size: float) -> None:
        """The same, with the forces of the step, and contact kept where it was for its first linear solves."""
        self.move_tools(time, size)
        for control in self.controls:
            control.begin(time, size)
            control.touch()
        for surface in self.rigid:
            surface.hold(time, size)
        for held in self._held_layers:
            held.begin()
        for _, multiplier in self._multipliers:
            multiplier.begin()
        self._note_held_tools()

    def release(self, solves: int) -> None:
        """Let contact go by the gap alone where it is kept for no more than a number of linear solves of a step."""
        for surface in self.rigid:
            surface.held.release(solves)
        for held in self._held_layers:
            held.release(solves)
        self._note_held_tools()

    def _note_held_tools(self) -> None:
        holds = any(surface.held.holds for surface in self.rigid)
        self._holding_tools = self.body.spaces.mesh.comm.allreduce(holds, MPI.LOR)

    @property
    def _held_layers(self) -> list[HeldLayers]:
        return [layer.held for layer in self.layers if layer.held is not None]

    @property
    def holding(self) -> bool:
        """Whether contact is kept where it was, whatever the gap."""
        return self._holding_tools or self.holding_layers

    @property
    def holding_layers(self) -> bool:
        """Whether layers that would touch nowhere are kept on each other."""
        return any(held.holds for held in self._held_layers)

    def touching(self) -> NDArray[np.bool_]:
        """At which of this rank's local nodes there is contact now, one contact after the other."""
        pressures = [contact.face.values(contact.pressure_form) for contact in self.all]
        return np.concatenate([np.zeros(0), *(values.ravel() for values in pressures)]) > 0

    def longest_step(self, time: float, size: float) -> float:
        """Step (s) from a time, no longer than a size, that no tool travels too far in, or beyond its first touch."""
        for tool in self.tools:
            speed = tool.speed_after(time)
            size = min(size, self._step_travel / speed) if speed else size
        return min((tool.step_to_touch(time, size) for tool in self.tools), default=size)

    def refresh(self) -> None:
        """Follow the present displacement."""
        for layer in self.layers:
            layer.refresh()

    def rest(self, time: float) -> None:
        """Tools at rest at a time (s) in the committed state; layers paired anew, in the present configuration."""
        for surface in self.rigid:
            surface.rest(time)
        self.pair()

    def pair(self) -> None:
        """Pair layers anew, in the present configuration."""
        for layer in self.layers:
            layer.update()
            self.pairings += 1

    def check_start(self) -> None:
        """Raise a SceneError that says how far to raise a tool, or to lower a mould, that starts in the stack."""
        for contact in self.rigid:
            check_depth(contact.name, contact.surface, contact.depth_at_start())

    def rollback(self, time: float) -> None:
        """Follow the body, which is in its committed state at a time (s) again."""
        for surface in self.rigid:
            surface.held.open()
            surface.rest(time)
        self._note_held_tools()
        for layer in self.layers:
            layer.rollback()

    def augment(self) -> tuple[float, int] | None:
        """Update the multipliers of contacts that penetrate too far.

        Returns:
            The deepest penetration among them in m, and the number of updates that the scene allows; None if all
            contacts with multipliers hold their tolerance.
        """
        too_deep = []
        for contact, multiplier in self._multipliers:
            deepest = contact.deepest()
            if multiplier.update(deepest):
                too_deep.append((deepest, multiplier.way.max_updates))
        return max(too_deep, default=None)

    @property
    def _multipliers(self) -> list[tuple[RigidContact | LayerContact, Multiplier]]:
        return [(contact, contact.multiplier) for contact in self.all if contact.multiplier is not None]

    def residual(self) -> Iterator[tuple[Integers, Floats]]:
        """Forces in N that act beside the compiled forms: global node numbers, and values of shape (nodes, 3)."""
        for layer in self.layers:
            yield layer.residual()

    def tangent(self) -> Iterator[Blocks]:
        """Their derivatives."""
        for layer in self.layers:
            yield from layer.tangent()

    def links(self) -> Iterator[tuple[Integers, Integers]]:
        """Global numbers of the nodes that those couple, rows (n, a) and columns (n, b)."""
        for layer in self.layers:
            yield from layer.links()


def _equal_interfaces(scene: Scene, stack: StackMesh) -> list[tuple[OneSided, list[int]]]:
    """Interfaces that may open, equal ones together, with their lower layers."""
    groups: list[tuple[OneSided, list[int]]] = []
    for layer in stack.open_interfaces:
        way = scene.interfaces[layer]
        assert isinstance(way, OneSided)
        known = next((layers for other, layers in groups if other == way), None)
        if known is None:
            groups.append((way, [layer]))
        else:
            known.append(layer)
    return groups
