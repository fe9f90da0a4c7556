"""Layers on layers: contact, stitching and friction of a lower face with what lies on it, pairs following the slip.

To its lower face, each interface is contact with a surface given node by node: the weighted position y of what faces
it.
The virtual work is stated once, for changes of the lower face and of y; what acts on y goes to the nodes of the upper
face by the same weights, so that forces balance whatever the two meshes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.contact.held_contact import HeldLayers
from ncf_fenicsx.contact.multiplier import multiplier_of
from ncf_fenicsx.contact.pairing import Pairing
from ncf_fenicsx.contact.tangent_blocks import Blocks, nodal_blocks, stress_blocks
from ncf_fenicsx.laws.contact import STIFFEST_LAYERS, Touch, friction_traction, tangential
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_fields import Location, StateField, field_on_face
from ncf_fenicsx.scene.interfaces import OneSided

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class LayerContact:
    """Contact at interfaces of one kind.

    Args:
        name: of the interfaces in a scene.
        settings: how the layers meet.
        face: the lower faces.
        pairing: what their nodes face.
        body: the fabric.
        area_vector: current normal of the lower faces times their area stretch.

    Attributes:
        term: virtual work (J) of the forces on the lower faces, to be added to the residual.
        slip: tangential displacement of what is faced since the start in m, at this rank's local nodes.
        pressure_form: compiled density of the contact pressure over the face in Pa, per undeformed area.
        held: holds layers that would touch nowhere; None where something pulls them back.
        multiplier: None unless the enforcement keeps one.
        traction: field with the tangential traction in Pa at the end of the last step; None without friction.
        slid: how far what is faced has slid over the lower faces in the step in m, without what springs back, times the
            share of each node that something faces, shape (3,); None without friction.
        state: all that the contact remembers.
    """

    def __init__(
        self, name: str, settings: OneSided, face: Face, pairing: Pairing, body: DeformedBody, area_vector: Expression
    ) -> None:
        self.name, self.settings, self.face, self.pairing, self.body = name, settings, face, pairing, body
        spaces, self.enforcement = body.spaces, settings.contact
        self._facing, self._facing_start, self._normal = (spaces.vector() for _ in range(3))
        self._coverage = spaces.scalar()
        self._slip_field = spaces.vector() if settings.slip_stiffness else None
        slip = StateField(
            f"{name}.slip", Location.NODES, np.zeros_like(self._facing.x.array), lambda: self.slipped().ravel()
        )
        self.slip, self.state = slip.committed.reshape(-1, 3), [slip]
        self._undeformed = spaces.scalars.tabulate_dof_coordinates()
        self._numbers = spaces.numbers
        self._area_form = face.density(area_vector)
        self.gap = ufl.dot(self._normal, self._facing - body.position)
        kept = None if settings.opening_stiffness else spaces.scalar()
        self.multiplier = multiplier_of(name, settings.contact, body, settings.penalty, STIFFEST_LAYERS)
        own = body.own_pressure if settings.contact.uses_own_pressure else None
        stiffness = body.constants(settings.penalty.resolve(body.natural_stiffness))
        touch = Touch(self.gap, stiffness, own_pressure=own, kept=kept)
        self.touch = touch if self.multiplier is None else self.multiplier.on(touch)
        self.pressure = settings.contact.pressure(self.touch)
        self.pressure_form = face.density(self._coverage * self.pressure)
        self.held: HeldLayers | None = None
        if kept is not None:
            nodes = [interface.lower.local for interface in pairing.interfaces]
            self.held = HeldLayers(face, kept, self.pressure_form, nodes)
        if self.multiplier is not None:
            self.multiplier.follow(face, face.density(self.pressure))
            self.state += self.multiplier.state
        self.traction = spaces.vector() if settings.friction is not None else None
        self.slid: Expression | None = None
        self._tangential = self._tangential_traction()
        self._compile()
        self.update()

    def _compile(self) -> None:
        body, measure = self.body, self.face.measure
        u, v, du = body.displacement, body.variation, ufl.TrialFunction(body.spaces.vectors)
        own = self.touch.own_pressure
        self.term = self._work(-v, None if own is None else ufl.derivative(own, u, v)) * measure
        upper = self._work(v, None if own is None else 0) * measure
        self._direction = fem.Constant(body.spaces.mesh, np.zeros(3))
        self._upper_force = compat.compile_form(upper)
        self._upper_stiffness = compat.compile_form(ufl.derivative(upper, self._facing, self._direction))
        self._stress_coupling: tuple[Any, ...] = ()
        if own is not None:
            self._stress_coupling = (
                compat.compile_form(ufl.derivative(self.term, self._facing, du)),
                compat.compile_form(ufl.derivative(upper, u, du)),
            )

    def _work(self, change: Expression, own_change: Expression) -> Expression:
        """Virtual work (J/m2) for a change of y - x, and of the layer's own pressure."""
        constants, n = self.body.constants, self._normal
        work = self.settings.contact.work(self.touch, ufl.dot(n, change), own_change)
        if self.settings.opening_stiffness:
            opening = constants(self.settings.opening_stiffness) * ufl.max_value(self.gap, 0)
            work += opening * ufl.dot(n, change)
        if self._tangential is not None:
            work += ufl.dot(self._tangential, change)
        return self._coverage * work

    def _tangential_traction(self) -> Expression | None:
        """Traction in Pa that resists slip: friction and stitches; None without either."""
        settings, constants = self.settings, self.body.constants
        moved = tangential(self._facing - self._facing_start - self.body.step_displacement, self._normal)
        traction = None
        if settings.friction is not None:
            stiffness = constants(settings.friction.stiffness.resolve(self.body.natural_stiffness))
            stuck = tangential(self.traction, self._normal) + stiffness * moved
            traction = friction_traction(stuck, self.pressure, constants(settings.friction.coefficient))
            self.slid = self._coverage * (stuck - traction) / stiffness
            density = self.face.density(traction)
            self.state.append(field_on_face(f"{self.name}.traction", self.traction, self.face, density))
        if self._slip_field is not None:
            stitches = constants(settings.slip_stiffness) * (tangential(self._slip_field, self._normal) + moved)
            traction = stitches if traction is None else traction + stitches
        return traction

    def refresh(self) -> None:
        """Take what the lower faces face at the present displacement."""
        self._at_nodes(self._facing, self.pairing.facing(self._positions()))
        if self.held is not None:
            self.held.watch()

    def residual(self) -> tuple[Integers, Floats]:
        """Forces on the upper faces as a residual in N: global node numbers, and values of shape (nodes, 3)."""
        local = fem.assemble_vector(self._upper_force).array.reshape(-1, 3)[self.pairing.nodes]
        forces = self.pairing.rows.T @ local
        loaded = np.flatnonzero(forces.any(axis=1))
        return self.pairing.masters[loaded], forces[loaded]

    def tangent(self) -> Iterator[Blocks]:
        """Blocks of the tangent that concern the upper faces."""
        yield from nodal_blocks(self.pairing, self._nodal_stiffness(), coupled_below=not self._stress_coupling)
        if self._stress_coupling:
            yield from stress_blocks(self.pairing, self._numbers, *self._stress_coupling)

    def links(self) -> Iterator[tuple[Integers, Integers]]:
        """Global numbers of the nodes that the tangent couples at any pressure, rows (n, a) and columns (n, b)."""
        return ((rows, columns) for rows, columns, _ in self.tangent())

    def slipped(self) -> Floats:
        """Slip in m in the trial state at this rank's local nodes, shape (nodes, 3)."""
        moved = self._facing.x.array - self._facing_start.x.array
        moved += self.body.start.x.array - self.body.displacement.x.array
        total, normal = self.slip + moved.reshape(-1, 3), self._normal.x.array.reshape(-1, 3)
        along: Floats = total - np.einsum("ij,ij->i", total, normal)[:, None] * normal
        return along

    def rollback(self) -> None:
        """Follow the body, which is in its committed state again."""
        if self.held is not None:
            self.held.end()
        self.refresh()

    def update(self) -> None:
        """Pair anew in the present configuration, with its normals."""
        positions = self._positions()
        self.pairing.update(positions)
        self._uncovered = np.ones(len(positions), dtype=bool)
        self._uncovered[self.pairing.nodes[self.pairing.coverage > 0]] = False
        self._coverage.x.array[self.pairing.nodes] = self.pairing.coverage
        vectors = self.face.assembled(self._area_form)[self.pairing.nodes]
        self._at_nodes(self._normal, vectors / np.linalg.norm(vectors, axis=1)[:, None])
        self._at_nodes(self._facing, self.pairing.facing(positions))
        if self.held is not None:
            self.held.note()
        self._facing_start.x.array[:] = self._facing.x.array
        if self._slip_field is not None:
            self._slip_field.x.array[:] = self.slip.ravel()

    def gaps(self) -> Floats:
        """Opening in m at this rank's local nodes, negative in penetration; 0 off the face and where nothing faces."""
        away = (self._facing.x.array.reshape(-1, 3) - self._positions()) * self._normal.x.array.reshape(-1, 3)
        return np.where(self._uncovered, 0.0, away.sum(axis=1))

    def deepest(self) -> float:
        """Deepest penetration of a node on all ranks in m, at least 0."""
        deepest = -self.gaps()[self.face.owned()].min(initial=0.0)
        return float(max(self.body.spaces.mesh.comm.allgather(deepest)))

    def _positions(self) -> Floats:
        positions: Floats = self._undeformed + self.body.displacement.x.array.reshape(-1, 3)
        return positions

    def _at_nodes(self, field: Any, values: Floats) -> None:
        field.x.array.reshape(-1, 3)[self.pairing.nodes] = values

    def _nodal_stiffness(self) -> Floats:
        """Derivative of the force on what a node faces by its place in N/m, this rank's part, shape (nodes, 3, 3)."""
        columns = []
        for direction in np.eye(3):
            self._direction.value[:] = direction
            columns.append(fem.assemble_vector(self._upper_stiffness).array.reshape(-1, 3)[self.pairing.nodes])
        return np.stack(columns, axis=2)
