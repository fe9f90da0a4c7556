"""The scene as an equation: fields, named residual terms summed once, trial and committed state."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.contacts import Contacts
from ncf_fenicsx.contact.deformed_body import Body
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mechanics.admissibility import Defects
from ncf_fenicsx.mechanics.fabric import Fabric
from ncf_fenicsx.mechanics.form_constants import FormSymbols
from ncf_fenicsx.mechanics.material import Clock, Material, Solid, Volumes
from ncf_fenicsx.mechanics.stabilising_viscosity import Viscosity
from ncf_fenicsx.mechanics.supports import hold
from ncf_fenicsx.mesh import StackMesh, compat
from ncf_fenicsx.mesh.elements import Element
from ncf_fenicsx.mesh.faces import NodalSpaces
from ncf_fenicsx.mesh.state_parts import Place, StatePart, under
from ncf_fenicsx.mesh.states import States, at_nodes, at_volume_points
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.tools import path as motion

Floats = NDArray[np.float64]

CELLS_AT_NODE = 4
"""Cells of a layer that add up their round-off at a node."""
FOREVER = 1e30
"""Time in s that a stack at rest has had: all that relaxes has relaxed."""


class Problem:
    """Fields and forms of a scene on its mesh.

    Only what the scene names is built: no contact form without a tool, no pairs in a bonded stack, no copy of the last
    iterate for a plain tangent, no state that no law keeps.

    Attributes:
        displacement: trial displacement in m.
        start: displacement in m at the start of the step, the committed one.
        last_iterate: displacement of the Newton iterate before; None unless the tangent extrapolates from it.
        material: the laws, with symbols for their parameters.
        states: committed state fields at quadrature points.
        face_states: the same at the nodes of cells; None unless a contact asks for the layer's own pressure there.
        contacts: tools, mould and layers on each other.
        viscosity: what steadies the stack in trouble; None before there was any.
        defects: finds what makes a trial state impossible.
        terms: named terms of the residual; their sum is what is solved.
        symmetric: whether the tangent is symmetric.
        weight_share: constant, the share of its weight that the stack carries while it settles; 1 after.
    """

    def __init__(self, scene: Scene, stack: StackMesh) -> None:
        self.scene, self.stack, self.mesh, self.comm = scene, stack, stack.mesh, stack.mesh.comm
        self.length, self.symmetric = scene.stack.thickness, scene.symmetric
        element = stack.element
        components = basix.ufl.blocked_element(element.basix(), shape=(3,))
        self.space = compat.nodal_space(self.mesh, components, element.has_bare_entities)
        self.displacement, self.start = fem.Function(self.space), fem.Function(self.space)
        extrapolates = scene.solver.tangent == "extrapolated" and scene.laws.solid is None
        self.last_iterate = fem.Function(self.space) if extrapolates else None
        self.variation, self.increment = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        self.volumes = _volumes(self.mesh, element)
        self.symbols = FormSymbols(self.mesh, stack.layer)
        self.weight_share = self.symbols(1.0)
        self.clock = Clock(self.symbols(0.0), self.symbols(0.0), self.symbols(0.0))
        self.states = self._states(at_volume_points(element))
        self.material = self._bind_laws(self.states)
        self.states.follow(self.material.updated_states(self.displacement))
        self.face_states: States | None = None
        self.supports = hold(self.space, stack, scene)
        kinematics = self.material.kinematics(self.displacement)
        self.contacts = Contacts(scene, stack, self._body(), kinematics.area_vector)
        self.terms = self._terms()
        self._compile()
        self.viscosity: Viscosity | None = None
        self.defects = Defects(stack, self.displacement, element.volume_rule[0], self.states, scene.packing_limit)
        self._velocity, self._drift = (np.zeros_like(self.start.x.array) for _ in range(2))
        self._segments = self._segments_at(0.0)
        self._set_time(0.0, 0.0)

    def _states(self, element: Any) -> States:
        initial = self.scene.laws.initial_states(self.scene.stack.initial_volume_fraction)
        return States(self.mesh, element, initial)

    def _bind_laws(self, states: States) -> Material:
        laws, symbols = self.scene.laws, self.symbols
        if laws.solid is not None:
            return Solid(laws.solid.with_symbols(symbols))
        vf0 = symbols(self.scene.stack.initial_volume_fraction)
        return Fabric(laws.with_symbols(symbols), vf0, self.clock, states.fields)

    def _body(self) -> Body:
        return Body(
            spaces=NodalSpaces(self.space, self.stack.element),
            displacement=self.displacement,
            start=self.start,
            variation=self.variation,
            symbols=self.symbols,
            own_pressure=self._own_pressure,
            natural_stiffness=self.scene.natural_stiffness,
            thickness=self.scene.stack.thickness,
        )

    def _own_pressure(self) -> Expression:
        """Pressure in Pa, per reference area, that the stress of a layer has on its faces, evaluated at nodes."""
        if self.face_states is None:
            self.face_states = self._states(at_nodes(self.stack.element))
            self._face_material = self._bind_laws(self.face_states)
            self.face_states.follow(self._face_material.updated_states(self.displacement))
        kinematics = self._face_material.kinematics(self.displacement)
        return -self._face_material.normal_stress(kinematics) * kinematics.area_stretch

    def _terms(self) -> dict[str, ufl.Form]:
        scene, u, v = self.scene, self.displacement, self.variation
        terms = {"internal": self.material.internal_work(u, v, self.volumes)}
        if scene.gravity:
            weight = scene.gravity * scene.stack.areal_density / scene.stack.thickness
            terms["gravity"] = self.symbols(weight) * self.weight_share * v[2] * self.volumes.all
        return terms | self.contacts.terms()

    def add_term(self, name: str, term: ufl.Form) -> None:
        """Add a term to the residual."""
        self.terms[name] = term
        self._compile()

    def _compile(self) -> None:
        self.residual_form = compat.compile_form(sum(self.terms.values()))
        self.__dict__.pop("tangent_form", None)

    @cached_property
    def tangent_form(self) -> Any:
        """Compiled derivative of the residual, for who needs it."""
        return compat.compile_form(self._tangent())

    def steady(self, coefficient: float) -> None:
        """Let a viscosity (Pa s/m2) act against motion that departs from the drift; its term comes with the first."""
        if coefficient and self.viscosity is None:
            inverse = self.clock.inverse_time_step
            self.viscosity = Viscosity(self.displacement, self.symbols(0.0), inverse)
            self.add_term("viscosity", self.viscosity.work(self.variation) * self.volumes.all)
        if self.viscosity is not None:
            self.viscosity.coefficient.value = coefficient

    def drift_on(self) -> None:
        """Have a viscosity not resist a motion such as that of the last step."""
        self._drift[:] = self._velocity

    def _tangent(self) -> ufl.Form:
        u, v, du = self.displacement, self.variation, self.increment
        tangent = ufl.derivative(sum(self.terms.values()), u, du)
        if isinstance(self.material, Fabric) and self.last_iterate is not None:
            tangent += self.material.extrapolated_tangent(u, self.last_iterate, v, du, self.volumes)
        return tangent

    @property
    def packs(self) -> NDArray[np.int64]:
        """Pack of layers that share nodes, of each owned node."""
        return self.stack.packs(self.space)

    @cached_property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off in the stiffest stress, or in penalty times place, leaves over."""
        comm = self.comm
        cells = comm.allreduce(len(self.stack.layer))
        one = compat.compile_form(self.symbols(1.0) * self.volumes.all)
        face = comm.allreduce(float(fem.assemble_scalar(one))) / cells / self.length
        round_off = self.scene.laws.stiffness + self.contacts.stiffness * self.stack.extent
        return float(CELLS_AT_NODE * np.finfo(float).eps * round_off * face * np.sqrt(cells))

    @property
    def increment_cap(self) -> float:
        """Largest nodal increment in m that Newton's method may take in the present step.

        A contact that passes from node to node has a jump for each; large corrections leap over many of them.
        """
        settings = self.scene.solver
        segments = [tool.path[motion.segment_number(tool.path, self._time)] for tool in self.scene.tool]
        along = any(segment.travel is not None and any(segment.travel[:2]) for segment in segments)
        return self.length * (min(settings.increment_cap, settings.travel_cap) if along else settings.increment_cap)

    def load(self, residual: Floats) -> float:
        """Sum of the vertical forces in N that carry the fabric, which imbalance is measured against.

        Args:
            residual: out-of-balance forces in N of the owned dofs, reactions included.
        """
        carried = float(np.abs(residual[self.supports.vertical_dofs]).sum())
        if self.contacts.mould is not None:
            carried += float(np.abs(self.contacts.mould.nodal_forces()[:, 2]).sum())
        return float(self.comm.allreduce(carried))

    def place(self, time: float, size: float) -> None:
        """Put the tools where they are after a step from ``time`` by ``size`` (s); the trial displacement stays."""
        self._set_time(time + size, size)
        self.contacts.place(time, size)

    def begin(self, time: float, size: float) -> None:
        """Put the tools where they are after a step from ``time`` by ``size`` (s), and predict the displacement."""
        if self.last_iterate is not None:
            self.last_iterate.x.array[:] = self.start.x.array
        same_way = self._segments_at(time + size) == self._segments
        self.displacement.x.array[:] = self.start.x.array + (size * self._velocity if same_way else 0.0)
        self._set_time(time + size, size)
        self.contacts.begin(time, size)
        self.contacts.refresh()
        self._drift *= same_way
        if self.viscosity is not None:
            self.viscosity.expect(self.start.x.array + size * self._drift)

    def commit(self, size: float) -> None:
        """Accept the trial state at the end of a step of ``size`` (s)."""
        trial = self.displacement.x.array
        self._velocity = (trial - self.start.x.array) / size if size else np.zeros_like(trial)
        self.contacts.commit(self._time, size)
        self.states.commit()
        if self.face_states is not None:
            self.face_states.commit()
        self.start.x.array[:] = trial
        self._set_time(self._time, 0.0)
        self.contacts.update()
        self._segments = self._segments_at(self._time)

    def perturb(self, change: Floats) -> None:
        """Change the committed displacement, of this rank's local dofs, by so much (m)."""
        self.start.x.array[:] += change
        self.displacement.x.array[:] = self.start.x.array
        self.contacts.refresh()

    def rollback(self, time: float) -> None:
        """Return to the committed state at ``time`` (s), bit for bit."""
        self.displacement.x.array[:] = self.start.x.array
        self.contacts.rollback(time)
        self._set_time(time, 0.0)

    def parts(self) -> dict[str, StatePart]:
        """The committed state, for a checkpoint."""
        start = self.start.x.array
        parts = {
            "displacement": StatePart(Place.NODES, lambda: start, lambda rows: np.copyto(start, rows.ravel())),
            "velocity": StatePart(
                Place.NODES, lambda: self._velocity, lambda rows: np.copyto(self._velocity, rows.ravel())
            ),
        }
        parts |= under("state", self.states.parts())
        if self.face_states is not None:
            parts |= under("face_state", self.face_states.parts())
        if self.scene.solver.may_steady:
            parts["drift"] = StatePart(
                Place.NODES, lambda: self._drift, lambda rows: np.copyto(self._drift, rows.ravel())
            )
        return parts | self.contacts.parts()

    def resume(self, time: float) -> None:
        """Go on from a committed state that has been read back, at a time (s)."""
        self.rollback(time)
        self.contacts.update()
        self._segments = self._segments_at(time)

    def _segments_at(self, time: float) -> list[int]:
        """Number of each tool's segment that ends at or after a time (s)."""
        return [motion.segment_number(tool.path, time) for tool in self.scene.tool]

    def _set_time(self, time: float, size: float) -> None:
        """Tell the laws the size of the step (s) that ends at a time, 0 at rest, and how fast the tools close in."""
        self._time = time
        self.clock.time_step.value = size or FOREVER
        self.clock.inverse_time_step.value = 1 / size if size else 0.0
        speeds = [motion.closing_speed(tool.path, time) for tool in self.scene.tool] if size else []
        self.clock.process_speed.value = max(speeds, key=abs, default=0.0)


def _volumes(mesh: Any, element: Element) -> Volumes:
    """Measures of the volume; the third axis of an element is that of its thickness."""

    def measure(points: Floats, weights: Floats) -> Any:
        rule = {"quadrature_rule": "custom", "quadrature_points": points, "quadrature_weights": weights}
        return ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2 * element.order} | rule)

    return Volumes(all=measure(*element.volume_rule), mid_plane=measure(*element.mid_plane_rule))
