"""The fabric on one rigid surface, whichever it is: gap, virtual work, pose in time, forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from scipy.optimize import brentq

from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.contact.held_contact import HeldTool
from ncf_fenicsx.contact.multiplier import multiplier_of
from ncf_fenicsx.laws.contact import STIFFEST_RIGID, Touch, friction_traction, tangential
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_fields import Location, StateField, field_on_face
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface, Tool
from ncf_fenicsx.tools.start import depth_at_start

Floats = NDArray[np.float64]

FREE = 1e-6
"""Gap over a layer's thickness above which a surface is free of the fabric."""
FREE_OVER_GAPS = 1e-3
"""The same where contact presses, and lets go, over gaps too: by a multiplier, or by the layer's own stress."""
HOLDING_SOLVES = 2
"""Linear solves at the start of a step that keep contact where it was."""


class RigidContact:
    """Contact of a face with a tool or a mould.

    Args:
        name: of the surface in a scene.
        surface: the rigid surface.
        face: of the fabric.
        body: the fabric.
        level: height of the undeformed face in m.

    Attributes:
        term: virtual work of the contact (J), to be added to the residual.
        tip: constant with the position of the tip of the surface in m.
        pressure_form: compiled density of the contact pressure over the undeformed face in Pa.
        held: where contact is kept for the first linear solves of a step.
        multiplier: None unless the enforcement keeps one.
        traction: field with the tangential traction in Pa at the end of the last step; None without friction.
        slid: how far the surface has slid over the fabric in the step in m, without what springs back, shape (3,); None
            without friction.
        state: all that the contact remembers.
    """

    def __init__(self, name: str, surface: RigidSurface, face: Face, body: DeformedBody, level: float) -> None:
        self.name, self.surface, self.face, self.body, self.level = name, surface, face, body, level
        self.enforcement, spaces = surface.contact, body.spaces
        self.tip, self._probe, self._advance, self._turn = (fem.Constant(spaces.mesh, np.zeros(3)) for _ in range(4))
        bound = surface.with_constants(body.constants)
        point = ufl.variable(body.position - self.tip)
        self.gap = bound.signed_distance(point)
        self._gap_form = face.density(bound.signed_distance(body.position - self._probe))
        self.multiplier = multiplier_of(name, surface.contact, body, surface.penalty, STIFFEST_RIGID)
        self.touch, kept = self._touch()
        self.pressure = surface.contact.pressure(self.touch)
        self.pressure_form = face.density(self.pressure)
        self.held = HeldTool(face, kept, self.pressure_form)
        self._offset = StateField(f"{name}.height_offset", Location.EVERYWHERE, np.zeros(1))
        self.state = [self._offset, self.held.state(f"{name}.active_set")]
        if self.multiplier is not None:
            self.multiplier.follow(face, self.pressure_form)
            self.state += self.multiplier.state
        self.traction, self._normal, traction = None, None, None
        self.slid: Expression | None = None
        if surface.friction is not None:
            self.traction, self._normal = spaces.vector(), spaces.vector()
            self._normal_form = face.density(ufl.diff(self.gap, point))
            traction = self._friction(point)
            self.state.append(field_on_face(f"{name}.traction", self.traction, face, face.density(traction)))
        self.term = self._work(traction)
        self.force_form = compat.compile_form(self.term)
        self._set_time(0.0, 0.0)

    def _touch(self) -> tuple[Touch, Any]:
        """What is known of the contact, and the field that says where it is kept."""
        surface, body = self.surface, self.body
        own = body.own_pressure if surface.contact.uses_own_pressure else None
        stiffness = body.constants(surface.penalty.resolve(body.natural_stiffness))
        kept = body.spaces.scalar()
        touch = Touch(self.gap, stiffness, own_pressure=own, kept=kept, rests=isinstance(surface, Mould))
        return (touch if self.multiplier is None else self.multiplier.on(touch)), kept

    def _work(self, traction: Expression) -> ufl.Form:
        """Virtual work (J) of the pressure, and of a tangential traction in Pa unless that is None."""
        body = self.body
        u, v = body.displacement, body.variation
        own = self.touch.own_pressure
        own_change = None if own is None else ufl.derivative(own, u, v)
        work = self.surface.contact.work(self.touch, ufl.derivative(self.gap, u, v), own_change)
        if traction is not None:
            work -= ufl.dot(traction, v)
        return work * self.face.measure

    def _friction(self, point: Expression) -> Expression:
        """Traction in Pa that drags the fabric along with the surface, across the normal at the start of the step."""
        surface, constants = self.surface, self.body.constants
        assert surface.friction is not None
        axle = surface.axle if isinstance(surface, Tool) else None
        arm = point - ufl.as_vector([0, 0, constants(axle or 0.0)])
        slip = self._advance + ufl.cross(self._turn, arm) - self.body.step_displacement
        stiffness = constants(surface.friction.stiffness.resolve(self.body.natural_stiffness))
        stuck = tangential(self.traction + stiffness * slip, self._normal)
        traction = friction_traction(stuck, self.pressure, constants(surface.friction.coefficient))
        self.slid = (stuck - traction) / stiffness
        return traction

    def move(self, time: float, size: float) -> None:
        """Put the surface where it is after a step from ``time`` by ``size`` (s)."""
        self._set_time(time, time + size)
        if self._normal is not None:
            self._normal.x.array[:] = self.face.values(self._normal_form).ravel()

    def hold(self, time: float, size: float) -> None:
        """Keep contact where it was for the first linear solves of that step."""
        before, now = self._tip_at(time), self._tip_at(time + size)
        self.held.hold(1 if now[2] > before[2] else HOLDING_SOLVES)

    def rest(self, time: float) -> None:
        """Put the surface where it is at a time (s), at rest in its committed state."""
        self._set_time(time, time)

    def shift(self, height: float) -> None:
        """Raise the surface by a height (m) within the step."""
        self._offset.values += height
        self.tip.value[2] += height
        self._advance.value[2] += height

    @property
    def height_offset(self) -> float:
        """What force control has added to the height of the surface in m, in the trial state."""
        return float(self._offset.values[0])

    def _set_time(self, before: float, now: float) -> None:
        """Place the surface; tell friction how it moved since ``before`` (s)."""
        surface = self.surface
        old, new = self._tip_at(before), self._tip_at(now)
        offset = np.array([0.0, 0.0, self.height_offset])
        before_step = np.array([0.0, 0.0, self._offset.committed[0]])
        self.tip.value[:] = new + offset
        self._advance.value[:] = new - old + offset - before_step
        if isinstance(surface, Tool) and surface.axle is not None:
            path = surface.path
            x, y, _ = np.subtract(motion.rolled(path, now), motion.rolled(path, before)) / surface.axle
            self._turn.value[:] = (-y, x, 0.0)

    def _tip_at(self, time: float) -> Floats:
        """Place of the surface's tip at a time (s) in m, without what forces add to its height."""
        surface = self.surface
        if isinstance(surface, Tool):
            return np.asarray(surface.tip(self.level, time))
        assert isinstance(surface, Mould)
        return np.asarray(surface.tip(self.level))

    def depth_at_start(self) -> float:
        """How far (m) the surface would have to move away along z, for the undeformed fabric to be free of it."""
        return depth_at_start(self.surface, self.tip.value, self._lowest_gap_from, 1e-6 * self.body.thickness)

    def speed_after(self, time: float) -> float:
        """Speed of a tool in m/s after a time (s), without what forces add to its height; 0 of a mould."""
        return motion.speed_after(self.surface.path, time) if isinstance(self.surface, Tool) else 0.0

    def step_to_touch(self, time: float, size: float) -> float:
        """Step (s) from a time, no longer than a size, at whose end a surface that is free meets the fabric at rest."""
        tolerance, offset = FREE * self.body.thickness, np.array([0.0, 0.0, self.height_offset])
        presses_over_gaps = self.enforcement.uses_own_pressure or self.enforcement.keeps_multiplier
        free = (FREE_OVER_GAPS if presses_over_gaps else FREE) * self.body.thickness

        def gap_after(step: float) -> float:
            return self._lowest_gap_from(self._tip_at(time + step) + offset) - tolerance

        touches = gap_after(0.0) > free and gap_after(size) < -2 * tolerance
        return float(brentq(gap_after, 0.0, size)) if touches else size

    def lowered(self) -> float:
        """How far the surface has moved down since the start in m."""
        tool = self.surface
        return float(tool.tip(self.level, 0.0)[2] - self.tip.value[2]) if isinstance(tool, Tool) else 0.0

    def gaps(self) -> Floats:
        """Distance of the face's nodes from the surface in m; 0 off the face."""
        return self._gaps_from(self.tip.value)

    def _gaps_from(self, tip: Floats) -> Floats:
        """The same of a surface with its tip at some position (m)."""
        self._probe.value[:] = tip
        return self.face.values(self._gap_form)

    def lowest_gap(self) -> float:
        """Smallest distance of a node from the surface on all ranks in m, negative in penetration."""
        return self._lowest_gap_from(self.tip.value)

    def _lowest_gap_from(self, tip: Floats) -> float:
        """The same of a surface with its tip at some position (m)."""
        lowest = self._gaps_from(tip)[self.face.owned()].min(initial=np.inf)
        return float(min(self.body.spaces.mesh.comm.allgather(lowest)))

    def deepest(self) -> float:
        """Deepest penetration of a node on all ranks in m, at least 0."""
        return max(-self.lowest_gap(), 0.0)

    def nodal_forces(self) -> Floats:
        """Forces of the fabric on the surface at this rank's owned nodes in N, shape (nodes, 3)."""
        return self.body.spaces.forces(self.force_form)

    def force(self) -> Floats:
        """Force of the fabric on the surface in N, of the modelled part, on all ranks; shape (3,)."""
        total: Floats = self.body.spaces.mesh.comm.allreduce(self.nodal_forces().sum(axis=0))
        return total
