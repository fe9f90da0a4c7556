"""The scene as an equation: fields, named residual terms summed once, trial and committed state."""

from __future__ import annotations

from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx import compat, motion
from ncf_fenicsx.contact import AT_NODES, penalty_work
from ncf_fenicsx.hexahedra import TAGS
from ncf_fenicsx.interface import LayerContact, PairedContact, pair_nodes
from ncf_fenicsx.kinematics import Expression
from ncf_fenicsx.mesh import StackMesh
from ncf_fenicsx.scene import OneSided, Scene
from ncf_fenicsx.supports import hold
from ncf_fenicsx.weak_form import BoundLaws, extrapolated_membrane_tangent, internal_work

Floats = NDArray[np.float64]

QUADRATURE_DEGREE = 2
PENALTY_VOLUME_FRACTION = 0.60
"""Penalty factors refer to the compaction tangent at this Vf, where the paper's compaction data ends."""


class Problem:
    """Fields and forms of a scene on its mesh.

    Only what the scene names is built: no contact form without a tool, no pairs in a bonded stack, no copy of the last
    iterate for a plain tangent.

    Attributes:
        displacement: trial displacement in m, P1.
        last_iterate: displacement of the Newton iterate before; None unless the tangent extrapolates from it.
        terms: named terms of the residual; their sum is what is solved.
        states: committed state fields at quadrature points, by name.
        coupling: contact between layers; None where the scene has none.
        tip: constant that holds the place of the tool's tip in m.
    """

    def __init__(self, scene: Scene, stack: StackMesh) -> None:
        self.scene, self.stack, self.mesh, self.comm = scene, stack, stack.mesh, stack.mesh.comm
        self.length = scene.stack.thickness
        self.space = fem.functionspace(self.mesh, ("Lagrange", 1, (3,)))
        self.displacement = fem.Function(self.space)
        self.last_iterate = fem.Function(self.space) if scene.solver.tangent == "extrapolated" else None
        self.variation, self.increment = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        self.dx = ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": QUADRATURE_DEGREE})
        self.ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=stack.facet_tags)
        self.speed, self.tip = self.constant(0.0), self.constant(np.zeros(3))
        self.laws = self._bind_laws()
        self.supports = hold(self.space, stack, scene.stack.sides)
        self.terms = self._terms()
        self.residual_form = compat.compile_form(sum(self.terms.values()))
        self.tangent_form = compat.compile_form(self._tangent())
        self.coupling = self._layer_contact()
        self._build_states()
        self._committed = self.displacement.x.array.copy()
        self._velocity = np.zeros_like(self._committed)
        self._segment = 0
        self._move_tool(0.0)

    def constant(self, value: Any) -> Any:
        """Named constant of the compiled forms."""
        return fem.Constant(self.mesh, np.asarray(value, dtype=float))

    def _bind_laws(self) -> BoundLaws:
        laws = self.scene.laws
        return BoundLaws(
            in_plane=laws.in_plane.with_symbols(self.constant),
            compaction=laws.compaction.with_symbols(self.constant),
            shear=laws.shear.with_symbols(self.constant),
            rate_factor=laws.rate.with_symbols(self.constant).factor(self.speed),
            initial_volume_fraction=self.constant(self.scene.stack.initial_volume_fraction),
        )

    def _terms(self) -> dict[str, ufl.Form]:
        scene, u, v = self.scene, self.displacement, self.variation
        terms = {"internal": internal_work(self.laws, u, v, self.dx)}
        if scene.gravity:
            weight = scene.gravity * scene.stack.areal_density / scene.stack.thickness
            terms["gravity"] = self.constant(weight) * v[2] * self.dx
        if scene.tool is not None:
            penalty = self.constant(scene.tool.penalty.resolve(self.natural_stiffness))
            terms["tool"] = penalty_work(self.tool_gap, penalty, u, v, self.ds(TAGS["top"]))
        return terms

    def _tangent(self) -> ufl.Form:
        u, v, du = self.displacement, self.variation, self.increment
        tangent = ufl.derivative(sum(self.terms.values()), u, du)
        if self.last_iterate is not None:
            tangent += extrapolated_membrane_tangent(self.laws, u, self.last_iterate, v, du, self.dx)
        return tangent

    @property
    def tool_gap(self) -> Expression:
        """Signed distance of current points from the tool in m."""
        assert self.scene.tool is not None
        tool = self.scene.tool.with_symbols(self.constant)
        return tool.signed_distance(ufl.SpatialCoordinate(self.mesh) + self.displacement - self.tip)

    @property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off in the fibres' stress leaves unbalanced."""
        comm = self.comm
        cells = comm.allreduce(len(self.stack.layer))
        volume = comm.allreduce(float(fem.assemble_scalar(compat.compile_form(self.constant(1.0) * self.dx))))
        face = (volume / cells) ** (2 / 3)
        return float(np.finfo(float).eps * self.scene.laws.in_plane.stiffness * face * np.sqrt(cells))

    @property
    def natural_stiffness(self) -> float:
        """Compaction tangent over thickness in Pa/m at `PENALTY_VOLUME_FRACTION` and the tool's highest speed."""
        scene = self.scene
        tangent = scene.laws.compaction.tangent(PENALTY_VOLUME_FRACTION, scene.stack.initial_volume_fraction)
        fastest = max((segment.speed or 0.0 for segment in scene.path), default=0.0)
        return float(tangent * scene.laws.rate.factor(fastest) / scene.stack.thickness)

    def _build_states(self) -> None:
        cell = self.mesh.basix_cell()
        element = basix.ufl.quadrature_element(cell, degree=QUADRATURE_DEGREE)
        space = fem.functionspace(self.mesh, element)
        points = compat.interpolation_points(space.element)
        kinematics = self.laws.kinematics(self.displacement)
        self._state_expressions = {"volume_fraction": compat.compile_expression(kinematics.volume_fraction, points)}
        self._cells = np.arange(len(self.stack.layer), dtype=np.int32)
        self.states = {"volume_fraction": fem.Function(space, name="volume_fraction")}
        self.states["volume_fraction"].x.array[:] = self.scene.stack.initial_volume_fraction

    def _layer_contact(self) -> LayerContact | None:
        """Contact between separate layers; a bonded stack, or a single layer, has none."""
        interface = self.scene.interface
        if not isinstance(interface, OneSided) or self.scene.stack.layers == 1:
            return None
        nodes = pair_nodes(self.space, self.stack)
        x = self.space.tabulate_dof_coordinates()
        distance = x[nodes[:, 1]] - x[nodes[:, 0]]
        distance[np.abs(distance) < 1e-6 * self.length] = 0.0  # round-off must not decide which pairs touch
        pairs = PairedContact(nodes, distance, interface.penalty.resolve(self.natural_stiffness), interface.stitching)
        normal = self.laws.kinematics(self.displacement).area_vector
        face = self.ds(TAGS["lower"], metadata=AT_NODES)
        return LayerContact(self.displacement, pairs, compat.compile_form(ufl.inner(normal, self.variation) * face))

    def begin(self, time: float, size: float) -> None:
        """Put the tool where it is after a step from ``time`` by ``size`` (s), and predict the displacement."""
        if self.last_iterate is not None:
            self.last_iterate.x.array[:] = self._committed
        same_way = motion.segment_number(self.scene.path, time + size) == self._segment
        self.displacement.x.array[:] = self._committed + (size * self._velocity if same_way else 0.0)
        self._move_tool(time + size)

    def defect(self) -> str | None:
        """Why the trial state is impossible, in words; None if it is possible."""
        trial = self._state_expressions["volume_fraction"].eval(self.mesh, self._cells)
        wrong = self.comm.allreduce(int(np.count_nonzero(~((trial > 0) & (trial < 1)))))
        if not wrong:
            return None
        return f"fibre volume fraction outside (0, 1) at {wrong} points: inverted or beyond solid fibre"

    def commit(self, size: float) -> None:
        """Accept the trial state at the end of a step of ``size`` (s)."""
        trial = self.displacement.x.array
        self._velocity = (trial - self._committed) / size if size else np.zeros_like(trial)
        self._committed = trial.copy()
        for name, field in self.states.items():
            field.interpolate(self._state_expressions[name])
        if self.coupling is not None:
            self.coupling.update_normals()
        self._segment = motion.segment_number(self.scene.path, self._time)

    def rollback(self, time: float) -> None:
        """Return to the committed state at ``time`` (s), bit for bit."""
        self.displacement.x.array[:] = self._committed
        self._move_tool(time)

    def _move_tool(self, time: float) -> None:
        self._time = time
        tool = self.scene.tool
        if tool is None:
            return
        self.tip.value[:] = tool.tip(self.stack.top, time)
        self.speed.value = motion.speed(tool.path, time)
