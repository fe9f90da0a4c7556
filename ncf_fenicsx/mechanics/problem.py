"""The scene as an equation: fields, named terms of the virtual work summed once, and what the stack remembers."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.contacts import Contacts
from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mechanics.admissibility import Admissibility
from ncf_fenicsx.mechanics.fabric import Fabric
from ncf_fenicsx.mechanics.form_constants import FormConstants
from ncf_fenicsx.mechanics.material import Clock, Material, Solid, Volumes
from ncf_fenicsx.mechanics.scales import Scales
from ncf_fenicsx.mechanics.supports import support
from ncf_fenicsx.mesh import StackMesh, compat
from ncf_fenicsx.mesh.faces import NodalSpaces
from ncf_fenicsx.mesh.state_fields import (
    Location,
    StateField,
    at_nodes,
    at_volume_points,
    fields_at_points,
    functions_at_points,
    towards_middle,
)
from ncf_fenicsx.scene import Scene


class Problem:
    """Fields and forms of a scene on its mesh.

    Only what the scene names is built: no contact form without a tool, no pairs in a bonded stack, no copy of the last
    iterate for a plain tangent, no state that no law keeps.

    Attributes:
        displacement: trial displacement in m.
        start: displacement in m at the start of the step, the committed one.
        last_iterate: displacement of the Newton iterate before; None unless the tangent extrapolates from it.
        material: the laws, with constants for their parameters.
        states: fields of state of the laws at the points that volumes are integrated with, by name.
        face_states: the same at the nodes of cells; empty unless a contact asks for the layer's own pressure there.
        contacts: tools, mould and layers on each other.
        admissibility: finds what makes a trial state impossible.
        scales: sizes that a solution is measured against.
        terms: named terms of the residual; their sum is what is solved.
        symmetric: whether the tangent is symmetric.
        weight_share: constant, the share of its weight that the stack carries while it settles; 1 after.
    """

    def __init__(self, scene: Scene, stack: StackMesh) -> None:
        scene = scene.with_tools_over(stack.position)
        self.scene, self.stack, self.mesh, self.comm = scene, stack, stack.mesh, stack.mesh.comm
        self.symmetric, element = scene.symmetric, stack.element
        components = basix.ufl.blocked_element(element.basix(), shape=(3,))
        self.space = compat.nodal_space(self.mesh, components, element.has_bare_entities)
        self.displacement, self.start = fem.Function(self.space), fem.Function(self.space)
        extrapolates = scene.solver.tangent == "extrapolated" and scene.laws.solid is None
        self.last_iterate = fem.Function(self.space) if extrapolates else None
        self.variation, self.increment = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        self.volumes = Volumes.on(self.mesh, element)
        self.constants = FormConstants(self.mesh, stack.layer)
        self.weight_share = self.constants(1.0)
        self.clock = Clock(self.constants)
        self.material, self.states = self._laws_at("state", at_volume_points(element))
        self.supports = support(self.space, stack, scene)
        self.face_states, own_pressure = self._at_faces()
        area_vector = self.material.kinematics(self.displacement).area_vector
        self.contacts = Contacts(scene, stack, self._body(own_pressure), area_vector)
        self.scales = Scales(scene, stack, self.contacts, self.supports, self.constants, self.volumes)
        vf = self.states.get("volume_fraction")
        self.admissibility = Admissibility(stack, self.displacement, element.volume_rule[0], vf, scene.packing_limit)
        self.terms = self._terms()
        self._forms = _Forms(self)

    def _laws_at(self, name: str, points: Any, shift: Expression = None) -> tuple[Material, dict[str, StateField]]:
        """The laws and their fields of state, by name, for strains at a shift (m) from the points of an element."""
        laws, constants = self.scene.laws, self.constants
        if laws.solid is not None:
            return Solid(laws.solid.with_constants(constants), shift), {}
        initial = self.scene.stack.initial_volume_fraction
        functions = functions_at_points(self.mesh, points, laws.initial_states(initial))
        thickness = constants(self.scene.stack.thickness)
        fabric = Fabric(laws.with_constants(constants), constants(initial), thickness, self.clock, functions, shift)
        return fabric, fields_at_points(name, functions, fabric.updated_states(self.displacement))

    def _at_faces(self) -> tuple[dict[str, StateField], Expression]:
        """Fields of state at nodes, and the pressure (Pa, per reference area) that the stress there has on a face.

        No fields and None unless a contact asks for that pressure.
        """
        if not self.scene.contact_uses_own_pressure:
            return {}, None
        element = self.stack.element
        shift = towards_middle(self.mesh, element.own_pressure_place)
        material, states = self._laws_at("face_state", at_nodes(element), shift)
        kinematics = material.kinematics(self.displacement)
        return states, -material.normal_stress(kinematics) * kinematics.area_stretch

    def _body(self, own_pressure: Expression) -> DeformedBody:
        return DeformedBody(
            spaces=NodalSpaces(self.space, self.stack.element),
            displacement=self.displacement,
            start=self.start,
            variation=self.variation,
            constants=self.constants,
            own_pressure=own_pressure,
            natural_stiffness=self.scene.natural_stiffness,
            thickness=self.scene.stack.thickness,
        )

    def _terms(self) -> dict[str, ufl.Form]:
        scene, u, v = self.scene, self.displacement, self.variation
        terms = {"internal": self.material.internal_work(u, v, self.volumes)}
        if scene.gravity:
            weight = scene.gravity * scene.stack.areal_density / scene.stack.thickness
            terms["gravity"] = self.constants(weight) * self.weight_share * v[2] * self.volumes.all
        return terms | self.contacts.terms()

    def add_term(self, name: str, term: ufl.Form) -> None:
        """Add a term to the residual."""
        self.terms = self.terms | {name: term}
        self._forms = _Forms(self)

    @property
    def residual_form(self) -> Any:
        """Compiled sum of all terms."""
        return self._forms.residual

    @property
    def tangent_form(self) -> Any:
        """Compiled derivative of the residual, for who needs it."""
        return self._forms.tangent

    @property
    def sublaminates(self) -> NDArray[np.int64]:
        """Number of the sublaminate, layers that share nodes, of each owned node."""
        return self.stack.sublaminates(self.space)

    @property
    def state(self) -> list[StateField]:
        """All that the stack remembers from step to step, its contacts included."""
        u = self.displacement.x.array
        displacement = StateField("displacement", Location.NODES, u, committed=self.start.x.array)
        return [displacement, *self.states.values(), *self.face_states.values(), *self.contacts.state]


class _Forms:
    """The compiled forms of a problem's terms; the tangent is compiled when it is asked for.

    Args:
        problem: whose terms, as they are now.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem, self._sum = problem, sum(problem.terms.values())
        self.residual = compat.compile_form(self._sum)

    @cached_property
    def tangent(self) -> Any:
        """Derivative of the residual, with the membrane stress extrapolated where the problem says so."""
        problem, u, v, du = self._problem, self._problem.displacement, self._problem.variation, self._problem.increment
        tangent: Expression = ufl.derivative(self._sum, u, du)
        if isinstance(problem.material, Fabric) and problem.last_iterate is not None:
            tangent += problem.material.extrapolated_tangent(u, problem.last_iterate, v, du, problem.volumes)
        return compat.compile_form(tangent)
