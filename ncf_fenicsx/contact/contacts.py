"""All contacts of a scene together: tools and mould on the outer faces, layers on each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import ufl
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.contact.catch import Catch
from ncf_fenicsx.contact.deformed_body import Body
from ncf_fenicsx.contact.force_control import ForceControl
from ncf_fenicsx.contact.layer_contact import LayerContact
from ncf_fenicsx.contact.pairing import Pairing
from ncf_fenicsx.contact.rigid_contact import RigidContact
from ncf_fenicsx.contact.tangent_blocks import Blocks
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.kinds import numbered
from ncf_fenicsx.laws.contact import AugmentedLagrangian
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.hexahedra import TAGS, lower_tag
from ncf_fenicsx.mesh.state_parts import StatePart, under
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import OneSided

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

    def __init__(self, scene: Scene, stack: StackMesh, body: Body, area_vector: Expression) -> None:
        self.body, tags, spaces = body, stack.facet_tags, body.spaces
        top = Face(spaces, tags, (TAGS["top"],)) if scene.tool else None
        self.tools = [RigidContact(tool, top, body, stack.top) for tool in scene.tool if top is not None]
        self.mould: RigidContact | None = None
        if scene.mould is not None:
            self.mould = RigidContact(scene.mould, Face(spaces, tags, (TAGS["bottom"],)), body, stack.bottom)
        self.layers: list[LayerContact] = []
        for way, layers in _equal_interfaces(scene, stack):
            face = Face(spaces, tags, tuple(lower_tag(layer) for layer in layers))
            self.layers.append(LayerContact(way, face, Pairing(spaces, stack, layers), body, area_vector))
        forced = [tool for tool in self.tools if tool.surface.under_force]
        self.pairings, self._gripping = 0, False
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
        """Largest contact stiffness in Pa/m, 0 without contact."""
        penalties = [surface.surface.penalty for surface in self.rigid] + [way.settings.penalty for way in self.layers]
        return max((penalty.resolve(self.body.natural_stiffness) for penalty in penalties), default=0.0)

    def terms(self) -> dict[str, ufl.Form]:
        """Virtual work (J) of each contact, by name."""
        terms = {name: contact.term for name, contact in zip(self.names, self.rigid, strict=True)}
        return terms | {numbered("interface", number): layer.term for number, layer in enumerate(self.layers)}

    def place(self, time: float, size: float) -> None:
        """Put the tools where they are after a step from ``time`` by ``size`` (s)."""
        for surface in self.rigid:
            surface.begin(time, size)

    def begin(self, time: float, size: float) -> None:
        """The same, with the forces of the step, and contact kept where it was for its first linear solves."""
        self.place(time, size)
        for control in self.controls:
            control.begin(time, size)
            control.touch()
        for surface in self.rigid:
            surface.hold(time, size)
        for catch in self._catches:
            catch.begin()
        self._note_grips()

    def release(self, solves: int) -> None:
        """Let contact go by the gap alone where it is kept for no more than a number of linear solves of a step."""
        for surface in self.rigid:
            surface.grip.release(solves)
        for catch in self._catches:
            catch.release(solves)
        self._note_grips()

    def _note_grips(self) -> None:
        holds = any(surface.grip.holds for surface in self.rigid)
        self._gripping = self.body.spaces.mesh.comm.allreduce(holds, MPI.LOR)

    @property
    def _catches(self) -> list[Catch]:
        return [layer.catch for layer in self.layers if layer.catch is not None]

    @property
    def keeping(self) -> bool:
        """Whether contact is kept where it was, whatever the gap."""
        return self._gripping or self.catching

    @property
    def catching(self) -> bool:
        """Whether layers that would touch nowhere are kept on each other."""
        return any(catch.holds for catch in self._catches)

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

    def commit(self, time: float, size: float) -> None:
        """Accept the trial state at the end of a step of ``size`` (s), before the body's start moves on."""
        for control in self.controls:
            control.commit(time, size)
        for surface in self.rigid:
            surface.grip.note()
            surface.commit(time)
        for layer in self.layers:
            layer.commit()

    def update(self) -> None:
        """Pair layers anew, in the present configuration."""
        for layer in self.layers:
            layer.update()
            self.pairings += 1

    def check_start(self) -> None:
        """Raise a SceneError that says how far to raise a tool, or to lower a mould, that starts in the stack."""
        for name, contact in zip(self.names, self.rigid, strict=True):
            depth = contact.depth_at_start()
            if depth > 0:
                given, enough = (
                    1e3 * contact.surface.clearance,
                    math.ceil(1e7 * (contact.surface.clearance + depth)) / 1e4,
                )
                raise SceneError(
                    f"{name}.clearance = {given:.6g} mm: it starts {1e3 * depth:.4g} mm inside the stack; "
                    f"expected at least {enough:.6g} mm"
                )

    @property
    def names(self) -> list[str]:
        """Names of tools and mould, as scene files and columns have them."""
        names = [numbered("tool", number) for number in range(len(self.tools))]
        return names + ["mould"] * (self.mould is not None)

    def rollback(self, time: float) -> None:
        """Return to the committed state at a time (s)."""
        for surface in self.rigid:
            surface.rollback(time)
        self._note_grips()
        for layer in self.layers:
            layer.rollback()

    def parts(self) -> dict[str, StatePart]:
        """The committed state of all contacts, for a checkpoint."""
        parts: dict[str, StatePart] = {}
        for name, contact in zip(self.names, self.rigid, strict=True):
            parts |= under(name, contact.parts())
        for number, layer in enumerate(self.layers):
            parts |= under(numbered("interface", number), layer.parts())
        for number, control in enumerate(self.controls):
            parts[numbered("control", number)] = control.part()
        return parts

    def augment(self) -> tuple[float, int] | None:
        """Update the multipliers of contacts that penetrate too far.

        Returns:
            The deepest penetration among them in m, and the number of updates that the scene allows; None if all
            contacts with multipliers hold their tolerance.
        """
        too_deep = []
        for contact in self.all:
            way = contact.enforcement
            if isinstance(way, AugmentedLagrangian):
                deepest = contact.deepest()
                if deepest > way.tolerance * self.body.thickness:
                    contact.memory.update("multiplier")
                    too_deep.append((deepest, way.max_updates))
        return max(too_deep, default=None)

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
