"""Closed forms of linear elasticity for solids near incompressibility: a thick tube and a bonded strip.

Small displacements: tangents of the undeformed solid on meshes and supports that no scene has.

Run: ``docker/run python3 tests/linear_solids.py``; prints the errors of both rules of integration.
"""

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import LinearProblem
from laws_by_number import law
from mpi4py import MPI

from ncf_fenicsx.mechanics.material import Solid, Volumes
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import Element

RATIOS = (0.3, 0.49, 0.499, 0.4999)
TUBES = ((1, [24, 24, 1]), (2, [10, 12, 1]))
"""Order and number of elements."""
HALF_WIDTH, STRIP = 20.0, [80, 1, 10]
MODULUS = 1.0
LU = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"}


class Linear:
    """Small displacements of a solid on a box of elements that a map of its points has bent."""

    def __init__(self, kind, poisson, order, counts, corner, bend=lambda x: x, rule="reduced"):
        box = mesh.create_box(MPI.COMM_SELF, [[0, 0, 0], corner], counts, mesh.CellType.hexahedron)
        element = Element(order)
        self.mesh = box
        components = basix.ufl.blocked_element(element.basix(), shape=(3,))
        self.space = compat.nodal_space(box, components, element.has_bare_entities)
        self.box_positions = self.space.tabulate_dof_coordinates().copy()
        box.geometry.x[:] = bend(box.geometry.x.T.copy()).T
        self.rest, self.variation = fem.Function(self.space), ufl.TestFunction(self.space)
        made = law("solid", kind, modulus=f"{MODULUS} Pa", poisson=poisson, volume_integration=rule)
        solid = Solid(made.with_constants(lambda value: fem.Constant(box, value)))
        work = solid.internal_work(self.rest, self.variation, Volumes.on(box, element))
        self.stiffness = ufl.derivative(work, self.rest, ufl.TrialFunction(self.space))

    def solve(self, held, load=None):
        """Displacements at nodes, from (components, where in the box, value) and a virtual work of loads."""
        conditions = []
        for axis, where, value in held:
            dofs = 3 * np.flatnonzero(where(self.box_positions.T)).astype(np.int32) + axis
            conditions.append(fem.dirichletbc(value, dofs, self.space.sub(axis)))
        load = ufl.inner(fem.Constant(self.mesh, np.zeros(3)), self.variation) * ufl.dx if load is None else load
        prefix = {} if compat.IS_0_9 else {"petsc_options_prefix": "linear_solid_"}
        found = LinearProblem(self.stiffness, load, bcs=conditions, petsc_options=LU, **prefix).solve()
        work = fem.assemble_scalar(fem.form(ufl.action(ufl.action(self.stiffness, found), found)))
        return found.x.array.reshape(-1, 3), work


def at(axis, value):
    return lambda x: np.isclose(x[axis], value)


def strip(kind, poisson, order, half_width, counts, rule="reduced"):
    """Apparent modulus of a long strip, 2 half_width wide and 1 high, bonded to rigid plates; upper right quarter."""
    linear = Linear(kind, poisson, order, counts, [half_width, 0.1, 0.5], rule=rule)
    held = [(0, at(0, 0.0), 0.0), (2, at(2, 0.0), 0.0), (0, at(2, 0.5), 0.0), (2, at(2, 0.5), -0.5)]
    held += [(1, at(1, y), 0.0) for y in (0.0, 0.1)]
    return linear.solve(held)[1] / (half_width * 0.1 * 0.5)


def strip_in_closed_form(poisson, half_width):
    """E_a = M - lambda^2/M tanh(kb)/(kb), k^2 = 12 mu/(M h^2), for parabolic bulging of a strip with h = 1.

    Incompressible it is 4/3 E (1 + S^2) of Gent and Lindley (1959), S = b/h; here with bulk compression.
    Its edges, where the pressure is not yet that of a strip without ends, leave 1.2 % at b = 10 and less beyond.
    """
    mu = MODULUS / (2 * (1 + poisson))
    lame = MODULUS * poisson / ((1 + poisson) * (1 - 2 * poisson))
    confined = lame + 2 * mu
    kb = np.sqrt(12 * mu / confined) * half_width
    return confined - lame**2 / confined * np.tanh(kb) / kb


def tube(kind, poisson, order, counts, rule="reduced"):
    """Growth of the inner radius of a thick tube, radii 1 and 2, plane strain, under a pressure of 1 inside."""

    def bend(x):
        radius, angle = 1 + x[0], x[1] * np.pi / 2
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), x[2]])

    linear = Linear(kind, poisson, order, counts, [1.0, 1.0, 0.1], bend, rule)
    facets = mesh.locate_entities_boundary(linear.mesh, 2, lambda x: np.isclose(np.hypot(x[0], x[1]), 1.0))
    inside = mesh.meshtags(linear.mesh, 2, np.sort(facets), np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=linear.mesh, subdomain_data=inside)
    load = -ufl.inner(ufl.FacetNormal(linear.mesh), linear.variation) * ds(1)
    held = [(1, at(1, 0.0), 0.0), (0, at(1, 1.0), 0.0), (2, at(2, 0.0), 0.0), (2, at(2, 0.1), 0.0)]
    moved, _ = linear.solve(held, load)
    start = at(0, 0.0)(linear.box_positions.T)
    return np.hypot(moved[start, 0], moved[start, 1]).mean()


def tube_in_closed_form(poisson):
    """u(a) = p a (1 + nu) ((1 - 2 nu) a^2 + b^2) / (E (b^2 - a^2)) (Lame; Timoshenko and Goodier, art. 28)."""
    return (1 + poisson) * ((1 - 2 * poisson) + 4) / (MODULUS * 3)


def errors(poisson, rule):
    """Relative errors of the tubes of both orders, and of the strips."""
    tubes = [tube("split", poisson, order, counts, rule) / tube_in_closed_form(poisson) for order, counts in TUBES]
    exact = strip_in_closed_form(poisson, HALF_WIDTH)
    strips = [strip("split", poisson, order, HALF_WIDTH, STRIP, rule) / exact for order in (1, 2)]
    return [ratio - 1 for ratio in tubes + strips]


if __name__ == "__main__":
    print("errors in per cent of reduced (full) integration: tube order 1, tube order 2, strip order 1, strip order 2")
    for poisson in RATIOS:
        pairs = zip(errors(poisson, "reduced"), errors(poisson, "full"), strict=True)
        print(f"nu = {poisson}:", ", ".join(f"{100 * reduced:.2f} ({100 * full:.2f})" for reduced, full in pairs))
