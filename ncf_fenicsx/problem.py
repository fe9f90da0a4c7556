"""The scene as an equation: fields, named residual terms summed once, trial and committed state."""

from __future__ import annotations

from typing import Any

import basix
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx import compat, motion
from ncf_fenicsx.contact import AT_NODES, penalty_work
from ncf_fenicsx.fabric import Fabric
from ncf_fenicsx.hexahedra import TAGS, place
from ncf_fenicsx.interface import LayerContact, PairedContact, pair_nodes
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.material import Clock, Material, Solid, Volumes
from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene_stack import OneSided
from ncf_fenicsx.states import States
from ncf_fenicsx.supports import hold
from ncf_fenicsx.symbols import FormSymbols

Floats = NDArray[np.float64]

QUADRATURE_DEGREE = 2
FOREVER = 1e30
"""Time in s that a stack at rest has had: all that relaxes has relaxed."""


class Problem:
    """Fields and forms of a scene on its mesh.

    Only what the scene names is built: no contact form without a tool, no pairs in a bonded stack, no copy of the last
    iterate for a plain tangent, no state that no law keeps.

    Attributes:
        displacement: trial displacement in m, P1.
        last_iterate: displacement of the Newton iterate before; None unless the tangent extrapolates from it.
        material: the laws, with symbols for their parameters.
        states: committed state fields at quadrature points.
        terms: named terms of the residual; their sum is what is solved.
        symmetric: whether the tangent is symmetric.
        coupling: contact between layers; None where the scene has none.
        tip: constant that holds the place of the tool's tip in m.
    """

    def __init__(self, scene: Scene, stack: StackMesh) -> None:
        self.scene, self.stack, self.mesh, self.comm = scene, stack, stack.mesh, stack.mesh.comm
        self.length, self.symmetric = scene.stack.thickness, scene.laws.symmetric
        self.space = fem.functionspace(self.mesh, ("Lagrange", 1, (3,)))
        self.displacement = fem.Function(self.space)
        extrapolates = scene.solver.tangent == "extrapolated" and scene.laws.solid is None
        self.last_iterate = fem.Function(self.space) if extrapolates else None
        self.variation, self.increment = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        self.volumes = _volumes(self.mesh)
        self.ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=stack.facet_tags)
        self.symbols = FormSymbols(self.mesh, stack.layer)
        self.clock = Clock(self.symbols(0.0), self.symbols(0.0), self.symbols(0.0))
        self.tip = fem.Constant(self.mesh, np.zeros(3))
        self.states = States(
            self.mesh, QUADRATURE_DEGREE, scene.laws.initial_states(scene.stack.initial_volume_fraction)
        )
        self.material = self._bind_laws()
        self.states.follow(self.material.updated_states(self.displacement))
        self.supports = hold(self.space, stack, scene.stack.sides)
        self.terms = self._terms()
        self.residual_form = compat.compile_form(sum(self.terms.values()))
        self.tangent_form = compat.compile_form(self._tangent())
        self.coupling = self._layer_contact()
        self._committed = self.displacement.x.array.copy()
        self._velocity = np.zeros_like(self._committed)
        self._segment = 0
        self._set_time(0.0, 0.0)

    def _bind_laws(self) -> Material:
        laws, symbols = self.scene.laws, self.symbols
        if laws.solid is not None:
            return Solid(laws.solid.with_symbols(symbols))
        vf0 = symbols(self.scene.stack.initial_volume_fraction)
        return Fabric(laws.with_symbols(symbols), vf0, self.clock, self.states.fields)

    def _terms(self) -> dict[str, ufl.Form]:
        scene, u, v = self.scene, self.displacement, self.variation
        terms = {"internal": self.material.internal_work(u, v, self.volumes)}
        if scene.gravity:
            weight = scene.gravity * scene.stack.areal_density / scene.stack.thickness
            terms["gravity"] = self.symbols(weight) * v[2] * self.volumes.all
        if scene.tool is not None:
            penalty = self.symbols(scene.tool.penalty.resolve(self.scene.natural_stiffness))
            terms["tool"] = penalty_work(self.tool_gap, penalty, u, v, self.ds(TAGS["top"]))
        return terms

    def _tangent(self) -> ufl.Form:
        u, v, du = self.displacement, self.variation, self.increment
        tangent = ufl.derivative(sum(self.terms.values()), u, du)
        if isinstance(self.material, Fabric) and self.last_iterate is not None:
            tangent += self.material.extrapolated_tangent(u, self.last_iterate, v, du, self.volumes)
        return tangent

    @property
    def tool_gap(self) -> Expression:
        """Signed distance of current points from the tool in m."""
        assert self.scene.tool is not None
        tool = self.scene.tool.with_symbols(self.symbols)
        return tool.signed_distance(ufl.SpatialCoordinate(self.mesh) + self.displacement - self.tip)

    @property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off in the stiffest stress leaves unbalanced."""
        comm = self.comm
        cells = comm.allreduce(len(self.stack.layer))
        one = compat.compile_form(self.symbols(1.0) * self.volumes.all)
        face = (comm.allreduce(float(fem.assemble_scalar(one))) / cells) ** (2 / 3)
        return float(np.finfo(float).eps * self.scene.laws.stiffness * face * np.sqrt(cells))

    def _layer_contact(self) -> LayerContact | None:
        """Contact between separate layers; a bonded stack, or a single layer, has none."""
        interface = self.scene.interface
        if not isinstance(interface, OneSided) or self.scene.stack.layers == 1:
            return None
        nodes = pair_nodes(self.space, self.stack)
        x = self.space.tabulate_dof_coordinates()
        distance = x[nodes[:, 1]] - x[nodes[:, 0]]
        distance[np.abs(distance) < 1e-6 * self.length] = 0.0  # round-off must not decide which pairs touch
        pairs = PairedContact(
            nodes, distance, interface.penalty.resolve(self.scene.natural_stiffness), interface.stitching
        )
        normal = self.material.kinematics(self.displacement).area_vector
        face = self.ds(TAGS["lower"], metadata=AT_NODES)
        return LayerContact(self.displacement, pairs, compat.compile_form(ufl.inner(normal, self.variation) * face))

    def begin(self, time: float, size: float) -> None:
        """Put the tool where it is after a step from ``time`` by ``size`` (s), and predict the displacement."""
        if self.last_iterate is not None:
            self.last_iterate.x.array[:] = self._committed
        same_way = motion.segment_number(self.scene.path, time + size) == self._segment
        self.displacement.x.array[:] = self._committed + (size * self._velocity if same_way else 0.0)
        self._set_time(time + size, size)

    def defect(self) -> str | None:
        """Why the trial state is impossible, in words; None if it is possible."""
        if "volume_fraction" not in self.states.fields:
            return None
        trial, (limit, whose) = self.states.trial("volume_fraction"), self.scene.packing_limit
        wrong = np.argwhere(~((trial > 0) & (trial < limit)))
        counts = self.comm.allgather(len(wrong))
        if not any(counts):
            return None
        places = self.states.places()  # compiles on all ranks together
        words = [self._name(trial, places, cell, point) for cell, point in wrong[:1]]
        first = next(found[0] for found in self.comm.allgather(words) if found)
        return f"fibre volume fraction outside (0, {limit:.4g}) ({whose}) at {sum(counts)} points, such as {first}"

    def _name(self, trial: Floats, places: Floats, cell: int, point: int) -> str:
        return f"{trial[cell, point]:.3g} at {place(places[cell, point])} in layer {self.stack.layer[cell] + 1}"

    def commit(self, size: float) -> None:
        """Accept the trial state at the end of a step of ``size`` (s)."""
        trial = self.displacement.x.array
        self._velocity = (trial - self._committed) / size if size else np.zeros_like(trial)
        self._committed = trial.copy()
        self.states.commit()
        if self.coupling is not None:
            self.coupling.update_normals()
        self._segment = motion.segment_number(self.scene.path, self._time)
        self._set_time(self._time, 0.0)

    def rollback(self, time: float) -> None:
        """Return to the committed state at ``time`` (s), bit for bit."""
        self.displacement.x.array[:] = self._committed
        self._set_time(time, 0.0)

    def _set_time(self, time: float, size: float) -> None:
        """Put the tool where it is at a time (s); tell the laws the size of the step that ends there, 0 at rest."""
        self._time = time
        self.clock.time_step.value = size or FOREVER
        self.clock.inverse_time_step.value = 1 / size if size else 0.0
        tool = self.scene.tool
        if tool is not None:
            self.tip.value[:] = tool.tip(self.stack.top, time)
            self.clock.process_speed.value = motion.closing_speed(tool.path, time) if size else 0.0


def _volumes(mesh: Any) -> Volumes:
    """Measures of the volume; the third axis of an element is that of its thickness."""
    points, weights = basix.make_quadrature(basix.CellType.quadrilateral, QUADRATURE_DEGREE)
    middle = np.column_stack([points, np.full(len(points), 0.5)])
    rule = {"quadrature_rule": "custom", "quadrature_points": middle, "quadrature_weights": weights}
    return Volumes(
        all=ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": QUADRATURE_DEGREE}),
        mid_plane=ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": QUADRATURE_DEGREE} | rule),
    )
