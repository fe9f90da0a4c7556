"""Solids near incompressibility: closed forms of one layer of elements, and a block under a roller, do not lock.

The closed forms are linear: tangents of the undeformed solid on meshes and supports that no scene has.
"""

import itertools

import basix.ufl
import numpy as np
import pytest
import ufl
from assembled import assign, build
from dolfinx import fem, mesh
from dolfinx.fem.petsc import LinearProblem
from laws_by_number import law
from mpi4py import MPI

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mechanics.material import Solid, Volumes
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import Element
from ncf_fenicsx.output.measures import Measures

pytestmark = pytest.mark.serial

MODULUS = 1.0
RATIOS = (0.3, 0.49, 0.499, 0.4999)
KINDS = ("logarithmic", "split")
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
        found = LinearProblem(self.stiffness, load, bcs=conditions, petsc_options=LU).solve()
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


@pytest.mark.parametrize(("order", "counts"), [(1, [24, 24, 1]), (2, [10, 12, 1])])
@pytest.mark.parametrize("poisson", RATIOS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_thick_tube_grows_by_its_closed_form(kind, poisson, order, counts):
    assert tube(kind, poisson, order, counts) == pytest.approx(tube_in_closed_form(poisson), rel=0.01)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("poisson", RATIOS)
def test_a_bonded_strip_has_the_stiffness_of_gent_and_lindley(poisson, order):
    computed = strip("split", poisson, order, 20.0, [80, 1, 10])
    assert computed == pytest.approx(strip_in_closed_form(poisson, 20.0), rel=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_full_integration_locks(kind):
    """What the tests above would find without the reduced rule."""
    assert tube(kind, 0.4999, 1, [24, 24, 1], "full") < 0.9 * tube_in_closed_form(0.4999)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_only_rigid_motions_of_an_element_are_free(kind, order):
    linear = Linear(kind, 0.4999, order, [1, 1, 1], [1.0, 0.8, 0.5])
    matrix = fem.assemble_matrix(fem.form(linear.stiffness)).to_dense()
    values = np.linalg.eigvalsh(matrix)
    assert np.all(np.abs(values[:6]) < 1e-9 * values[-1])
    assert values[6] > 1e-3 * MODULUS * 0.5


def block(poisson, divisions, through, **solid):
    """A roller on a long block; the same contact at any Poisson's ratio."""
    return {
        "gravity": "0 m/s^2",
        "laws": {"solid": {"modulus": "1 MPa", "poisson": poisson} | solid},
        "stack": {
            "layers": 1,
            "thickness": "8 mm",
            "size": ["20 mm", "1 mm"],
            "through": through,
            "divisions": [divisions, 1],
            "grading": [0, 0],
            "sides": {"y_max": "symmetry"},
        },
        "tool": {
            "radius": "10 mm",
            "width": "infinite",
            "path": [{"travel": ["0 mm", "0 mm", "-0.5 mm"], "speed": "1 mm/min"}],
        },
        "output": {"picture": False, "report": False, "fields_every": 1000},
    }


FINE = {0.499: 1.9453, 0.4999: 1.9477}
"""Force in N, extrapolated from 40 x 12 and 80 x 24 elements by the square of their size: docs/verification.md."""


@pytest.mark.parametrize("poisson", FINE)
def test_a_roller_on_rubber_takes_the_force_of_refinement(poisson, folder):
    result = run(Scene.from_table(block(poisson, 20, 6)), folder)
    assert result.done, result.reason
    assert result.history[-1]["tool_force"] == pytest.approx(FINE[poisson], rel=0.01)


def test_a_plate_on_a_block_whose_sides_are_free_takes_the_uniaxial_force(folder):
    """Homogeneous, so that any rule is exact: the moduli are those of the energies."""
    for kind, poisson in itertools.product(KINDS, RATIOS):
        table = block(poisson, 4, 2, kind=kind)
        table["tool"] = {"kind": "plate", "path": table["tool"]["path"]}
        table["stack"]["sides"] = {"y_max": "free"}
        result = run(Scene.from_table(table), folder, overwrite=True)
        assert result.done, result.reason
        force = result.history[-1]["tool_force"] / (4 * 20e-6)
        stretch = 1 - result.history[-1]["tool_displacement"] / 8e-3
        assert force == pytest.approx(uniaxial(kind, poisson, stretch), rel=2e-3), (kind, poisson)


def test_stress_of_cells_is_that_which_does_the_work(table):
    """A cell bent to a wedge, its volume kept: at its points J differs from 1 by some per cent, or tens of MPa."""
    largest = {}
    for rule in ("reduced", "full"):
        problem, _ = build(table | block(0.4999, 1, 1, volume_integration=rule))
        assign(problem, lambda x: np.stack([0.1 * x[0] * (x[2] - 4e-3) / 8e-3, 0 * x[0], 0 * x[0]]))
        measures = Measures(problem)
        measures.observe(np.zeros(3 * problem.contacts.body.spaces.owned), 0.0)
        largest[rule] = np.abs(measures.cells["stress_33"]).max()
    assert largest["reduced"] < 0.1e6
    assert largest["full"] > 0.2e6


def uniaxial(kind, poisson, stretch):
    """Force over undeformed area in Pa of a bar, its sides free: by hand from the energies of docs/laws.md."""
    mu, bulk = 1e6 / (2 * (1 + poisson)), 1e6 / (3 * (1 - 2 * poisson))
    lame = bulk - 2 * mu / 3

    def stresses(side):
        volume = stretch * side**2
        if kind == "logarithmic":
            both = (-mu + lame * np.log(volume)) * np.ones(2)
            return (mu * np.array([stretch**2, side**2]) + both) / np.array([stretch, side])
        squares = np.array([stretch**2, side**2])
        shape = mu * volume ** (-2 / 3) * (squares - (stretch**2 + 2 * side**2) / 3)
        return (shape + bulk * (volume - 1) * volume) / np.array([stretch, side])

    low, high = 0.9, 1.2
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if stresses(middle)[1] < 0 else (low, middle)
    return -stresses(low)[0]


def test_what_does_not_hold_is_refused_or_named():
    for poisson in (0.49991, 0.5):
        with pytest.raises(SceneError, match=r"laws\.solid\.poisson.*0\.4999"):
            Scene.from_table(block(poisson, 4, 2))
    nitsche = block(0.49, 4, 2)
    nitsche["tool"]["contact"] = {"kind": "nitsche"}
    with pytest.raises(SceneError, match=r"laws\.solid\.poisson.*Nitsche"):
        Scene.from_table(nitsche)
    cautions = Scene.from_table(block(0.49, 4, 2, volume_integration="full")).cautions
    assert any("lock" in words for words in cautions)
    assert not Scene.from_table(block(0.3, 4, 2, volume_integration="full")).cautions
    assert not Scene.from_table(block(0.4999, 4, 2)).cautions
