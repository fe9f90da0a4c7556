"""The fabric on one rigid surface, whichever it is: gap, virtual work, pose in time, forces."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from scipy.optimize import brentq

from ncf_fenicsx.contact.deformed_body import Body
from ncf_fenicsx.contact.grip import Grip
from ncf_fenicsx.laws.contact import Touch, friction_traction, tangential
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.memory import Memory
from ncf_fenicsx.mesh.state_parts import Place, StatePart
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface, Tool

Floats = NDArray[np.float64]

FREE = 1e-6
"""Gap over a layer's thickness above which a surface is free of the fabric."""
KEEPING_SOLVES = 2
"""Linear solves at the start of a step that keep contact where it was."""


class RigidContact:
    """Contact of a face with a tool or a mould.

    Args:
        surface: the rigid surface.
        face: of the fabric.
        body: the fabric.
        rest: height in m of the undeformed face.

    Attributes:
        term: virtual work of the contact (J), to be added to the residual.
        tip: constant with the place of the surface's tip in m.
        pressure_form: compiled density of the contact pressure over the undeformed face in Pa.
        grip: where contact is kept for the first linear solve of a step.
        memory: multiplier and tangential traction at the nodes, where the scene names what keeps them.
    """

    def __init__(self, surface: RigidSurface, face: Face, body: Body, rest: float) -> None:
        self.surface, self.face, self.body, self.rest = surface, face, body, rest
        self.enforcement = surface.contact
        zero = np.zeros(3)
        mesh = body.spaces.mesh
        self.tip, self._advance, self._turn = (fem.Constant(mesh, zero) for _ in range(3))
        self.memory, self.heave, self._committed_heave = Memory(face), 0.0, 0.0
        point = ufl.variable(body.place - self.tip)
        self.gap = surface.with_symbols(body.symbols).signed_distance(point)
        own = body.own_pressure() if surface.contact.uses_own_pressure else None
        stiffness = body.symbols(surface.penalty.resolve(body.natural_stiffness))
        multiplier = self.memory.scalar("multiplier") if surface.contact.keeps_multiplier else None
        self.grip = Grip(face)
        self.touch = Touch(self.gap, stiffness, multiplier, own, self.grip.kept, rests=isinstance(surface, Mould))
        self.pressure = surface.contact.pressure(self.touch)
        self.pressure_form = face.density(self.pressure)
        self.grip.follow(self.pressure_form)
        if multiplier is not None:
            self.memory.follow("multiplier", self.pressure_form)
        self._normal = body.spaces.vector() if surface.friction is not None else None
        self._normal_form = face.density(ufl.diff(self.gap, point)) if surface.friction is not None else None
        self.term = self._work(point)
        self.force_form = compat.compile_form(self.term)
        self._gap_form = face.density(self.gap)
        self._set_time(0.0, 0.0)

    def _work(self, point: Expression) -> ufl.Form:
        body = self.body
        u, v = body.displacement, body.variation
        own = self.touch.own_pressure
        own_change = None if own is None else ufl.derivative(own, u, v)
        work = self.surface.contact.work(self.touch, ufl.derivative(self.gap, u, v), own_change)
        if self._normal is not None:
            work -= ufl.dot(self._friction(point), v)
        return work * self.face.measure

    def _friction(self, point: Expression) -> Expression:
        """Traction in Pa that drags the fabric along with the surface, across the normal at the start of the step."""
        surface, symbols = self.surface, self.body.symbols
        assert surface.friction is not None
        axle = surface.axle if isinstance(surface, Tool) else None
        arm = point - ufl.as_vector([0, 0, symbols(axle or 0.0)])
        slip = self._advance + ufl.cross(self._turn, arm) - self.body.motion
        stiffness = symbols(surface.friction.stiffness.resolve(self.body.natural_stiffness))
        stuck = tangential(self.memory.vector("traction") + stiffness * slip, self._normal)
        traction = friction_traction(stuck, self.pressure, symbols(surface.friction.coefficient))
        self.memory.follow("traction", self.face.density(traction))
        return traction

    def begin(self, time: float, size: float) -> None:
        """Put the surface where it is after a step from ``time`` by ``size`` (s)."""
        self._set_time(time, time + size)
        if self._normal is not None:
            self._normal.x.array[:] = self.face.values(self._normal_form).ravel()

    def hold(self, time: float, size: float) -> None:
        """Keep contact where it was for the first linear solves of that step."""
        before, now = self._tip_at(time), self._tip_at(time + size)
        self.grip.hold(1 if now[2] > before[2] else KEEPING_SOLVES)

    def commit(self, time: float) -> None:
        """Accept the trial state at a time (s)."""
        self.memory.commit()
        self._committed_heave = self.heave
        self._set_time(time, time)

    def rollback(self, time: float) -> None:
        """Return to the committed state at a time (s)."""
        self.memory.rollback()
        self.grip.release(KEEPING_SOLVES)
        self.heave = self._committed_heave
        self._set_time(time, time)

    def parts(self) -> dict[str, StatePart]:
        """The committed state, for a checkpoint."""
        heave = StatePart(Place.EVERYWHERE, lambda: np.array([self._committed_heave]), self._set_heave)
        return {"heave": heave, "grip": self.grip.part()} | self.memory.parts()

    def _set_heave(self, rows: Floats) -> None:
        self._committed_heave = float(rows[0])

    def shift(self, height: float) -> None:
        """Raise the surface by a height (m) within the step."""
        self.heave += height
        self.tip.value[2] += height
        self._advance.value[2] += height

    def _set_time(self, before: float, now: float) -> None:
        """Place the surface; tell friction how it moved since ``before`` (s)."""
        surface = self.surface
        old, new = self._tip_at(before), self._tip_at(now)
        heaved = np.array([0.0, 0.0, self.heave])
        self.tip.value[:] = new + heaved
        self._advance.value[:] = new - old + heaved - [0.0, 0.0, self._committed_heave]
        if isinstance(surface, Tool) and surface.axle is not None:
            path = surface.path
            x, y, _ = np.subtract(motion.rolled(path, now), motion.rolled(path, before)) / surface.axle
            self._turn.value[:] = (-y, x, 0.0)

    def _tip_at(self, time: float) -> Floats:
        """Place of the surface's tip at a time (s) in m, without what forces add to its height."""
        surface = self.surface
        if isinstance(surface, Tool):
            return np.asarray(surface.tip(self.rest, time))
        assert isinstance(surface, Mould)
        return np.asarray(surface.tip(self.rest))

    def depth_at_start(self) -> float:
        """How far (m) the surface would have to move away along z, for the undeformed fabric to be free of it."""
        away, tip = (1.0 if isinstance(self.surface, Tool) else -1.0), self.tip.value.copy()
        moved, tolerance = 0.0, 1e-6 * self.body.thickness
        for _ in range(100):  # a distance is no longer than that along z: each move is short of the last, if at all
            depth = -self.lowest_gap()
            if depth <= tolerance:
                break
            moved += depth
            self.tip.value[2] = tip[2] + away * moved
        self.tip.value[:] = tip
        return moved

    def speed_after(self, time: float) -> float:
        """Speed of a tool in m/s after a time (s), without what forces add to its height; 0 of a mould."""
        return motion.speed_after(self.surface.path, time) if isinstance(self.surface, Tool) else 0.0

    def step_to_touch(self, time: float, size: float) -> float:
        """Step (s) from a time, no longer than a size, at whose end a surface that is free meets the fabric at rest."""
        tolerance = FREE * self.body.thickness

        def gap_after(step: float) -> float:
            self._set_time(time, time + step)
            return self.lowest_gap() - tolerance

        touches = gap_after(0.0) > tolerance and gap_after(size) < -2 * tolerance
        step = float(brentq(gap_after, 0.0, size)) if touches else size
        self._set_time(time, time)
        return step

    def lowered(self) -> float:
        """How far the surface has moved down since the start in m."""
        tool = self.surface
        return float(tool.tip(self.rest, 0.0)[2] - self.tip.value[2]) if isinstance(tool, Tool) else 0.0

    def gaps(self) -> Floats:
        """Distance of the face's nodes from the surface in m; 0 off the face."""
        return self.face.values(self._gap_form)

    def lowest_gap(self) -> float:
        """Smallest distance of a node from the surface on all ranks in m, negative in penetration."""
        lowest = self.gaps()[self.face.owned()].min(initial=np.inf)
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
