"""Elements of order 2 in the plane: their nodes, fields, integrals and pieces, on any number of ranks."""

import meshio
import numpy as np
import pytest
import ufl
from assembled import COMM, assign, build, gradient_error
from dolfinx import fem

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import Element, sub_quads
from ncf_fenicsx.report.reading import read_snapshots

X, Y, LAYERS, THICKNESS = 3, 2, 2, 2e-3


def coarse(**stack):
    return {
        "stack": {"layers": LAYERS, "size": ["12 mm", "6 mm"], "divisions": [X, Y], "grading": [0, 0], "order": 2}
        | stack,
        "duration": "1 s",
    }


def curved(x):
    """Quadratic in the plane, linear across it, in mm of positions in m."""
    a, b, c = 1e3 * x
    return np.stack([1e-6 * a**2 * b, 1e-6 * b**2 * (1 + c), 1e-6 * (a**2 * b**2 + a * c)])


def total(form):
    return COMM.allreduce(fem.assemble_scalar(compat.compile_form(form)))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("through", [1, 2])
def test_every_node_bears_a_value_and_has_one_number(order, through):
    problem, _ = build(coarse(order=order, through=through))
    owned = problem.space.dofmap.index_map.size_local
    along = (order * X + 1) * (order * Y + 1)
    assert problem.space.dofmap.index_map.size_global == along * LAYERS * (through + 1)
    numbers = np.concatenate(COMM.allgather(problem.stack.node_numbers(problem.space)[:owned]))
    assert np.array_equal(np.sort(numbers), np.arange(along * LAYERS * (through + 1)))
    positions = problem.space.tabulate_dof_coordinates()
    steps = positions / [12e-3 / (order * X), 6e-3 / (order * Y), THICKNESS / through]
    assert np.abs(steps - np.rint(steps)).max(initial=0.0) < 1e-9


@pytest.mark.parametrize("order", [1, 2])
def test_a_field_of_the_elements_order_is_met_exactly(order):
    problem, _ = build(coarse(order=order))
    assign(problem, curved)
    x = ufl.SpatialCoordinate(problem.mesh)
    exact = ufl.as_vector(
        [1e3 * x[0] ** 2 * x[1], x[1] ** 2 * (1 + 1e3 * x[2]), 1e6 * x[0] ** 2 * x[1] ** 2 + x[0] * x[2]]
    )
    off = ufl.grad(problem.displacement) - ufl.grad(exact)
    dx = ufl.dx(problem.mesh, degree=6)
    error = np.sqrt(total(ufl.inner(off, off) * dx) / total(ufl.inner(ufl.grad(exact), ufl.grad(exact)) * dx))
    assert error < 1e-12 if order == 2 else error > 0.05


def test_rules_of_integration_are_exact_for_what_elements_need():
    """Volumes: products of two fields; faces: a pressure's share of each node by Simpson's rule."""
    problem, _ = build(coarse())
    assign(problem, curved)
    u, face = problem.displacement, problem.contacts.layers[0].face
    fine = total(ufl.inner(u, u) * ufl.dx(problem.mesh, degree=8))
    assert total(ufl.inner(u, u) * problem.volumes.all) == pytest.approx(fine, rel=1e-12)
    element = 12e-3 / X * 6e-3 / Y
    shares = face.area[face.owned()] / element * 36
    positions = problem.space.tabulate_dof_coordinates()[face.owned()]
    inner = (np.abs(positions[:, 0] - 6e-3) < 5.9e-3) & (np.abs(positions[:, 1] - 3e-3) < 2.9e-3)
    assert set(np.rint(shares[inner]).astype(int)) <= {16, 8, 4}
    assert COMM.allreduce(face.area[face.owned()].sum()) == pytest.approx(72e-6, rel=1e-12)
    assert shares[inner] == pytest.approx(np.rint(shares[inner]), abs=1e-9)


def test_the_tangent_is_the_derivative_of_the_residual():
    soft = {"in_plane": {"modulus": "1 MPa"}, "bending": {"modulus": "0.1 MPa"}}
    table = coarse() | {"interface": {"kind": "bonded"}, "laws": soft, "solver": {"tangent": "plain"}}
    problem, newton = build(table)
    assign(problem, curved)
    assert gradient_error(problem, newton, 1e-9) < 1e-6


def test_fields_are_written_in_pieces_between_nodes(folder):
    table = coarse() | {"output": {"picture": False, "report": False}}
    result = run(Scene.from_table(table), folder)
    assert result.done, result.reason
    mesh = meshio.read(folder / read_snapshots(folder)[-1][1])
    corners = mesh.points[mesh.cells_dict["hexahedron"]]
    assert len(corners) == 4 * X * Y * LAYERS
    edges = [corners[:, number] - corners[:, 0] for number in (1, 3, 4)]
    volumes = np.einsum("ij,ij->i", np.cross(edges[0], edges[1]), edges[2])
    assert volumes == pytest.approx(np.full(len(corners), 72e-6 * THICKNESS / (4 * X * Y)), rel=1e-9)
    layers = mesh.cell_data_dict["layer"]["hexahedron"]
    assert np.array_equal(layers, np.where(corners[:, :, 2].mean(axis=1) < THICKNESS, 1, 2))
    sunk = mesh.point_data["displacement"][mesh.points[:, 2] > 1.9 * THICKNESS, 2]
    assert np.all(sunk < 0), "under its own weight, at every node"


@pytest.mark.serial
def test_pieces_of_an_element_share_its_corners_and_faces():
    element = Element(2)
    corners = element.nodes[element.hexahedra]
    assert np.ptp(corners, axis=1) == pytest.approx(np.tile([0.5, 0.5, 1.0], (4, 1)))
    assert sorted(corners.mean(axis=1)[:, :2].tolist()) == [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]]
    upper = element.nodes[element.faces[5]]
    assert np.array_equal(upper[:, 2], np.ones(9))
    assert np.array_equal(upper[:, 0] + 3 * upper[:, 1], [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4])
    assert np.array_equal(sub_quads(np.array([[5, 6, 7, 8]])), [[5, 6, 7, 8]])


@pytest.mark.serial
@pytest.mark.parametrize("order", [0, 3, "two"])
def test_other_orders_are_refused(order):
    with pytest.raises(SceneError, match=r"stack\.order"):
        Scene.from_table(coarse(order=order))
