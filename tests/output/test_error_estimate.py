"""The estimated error of a field of cell means against its true error."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.upright import NONE, Upright
from ncf_fenicsx.output.error_estimate import Recovery
from ncf_fenicsx.output.face_pressures import FacePressures
from ncf_fenicsx.report.reference_solution import VfField
from ncf_fenicsx.simulation import Simulation

pytestmark = pytest.mark.two_ranks

COMM = MPI.COMM_WORLD
LENGTH = 8e-3


def spaces(scene):
    """Mesh of a scene, its nodal space, the space's recovery, and its rank's cells as boxes: low and high corners."""
    mesh = build_mesh(scene, COMM)
    scalars = fem.functionspace(mesh.mesh, ("Lagrange", 1))
    corners = scalars.tabulate_dof_coordinates()[scalars.dofmap.list[: len(mesh.layer)]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    volumes = (high - low).prod(axis=1)
    return mesh, Recovery(scalars, volumes, Upright.of(scalars)), low, high, volumes


def effectivity(count, integral, square):
    """Estimated over true error of the cell means of a field of x, given its integral and that of its square."""
    stack = {"layers": 2, "size": [f"{LENGTH} m", "2 mm"], "divisions": [count, 2], "grading": [0, 0]}
    _, recovery, low, high, volumes = spaces(Scene.from_table({"duration": "1 s", "stack": stack}))
    h, low, high = LENGTH / count, low[:, 0], high[:, 0]
    means = (integral(high) - integral(low)) / h
    true = ((square(high) - square(low)) / h - means**2) @ volumes
    estimated, true = COMM.allreduce(np.array([recovery.squares(means) @ volumes, true]))
    return np.sqrt(estimated / true)


def test_the_estimate_tends_to_the_true_error():
    """A wave whose cell means have a known error."""
    k = 2 * np.pi / LENGTH
    wave = (lambda x: -np.cos(k * x) / k, lambda x: x / 2 - np.sin(2 * k * x) / (4 * k))
    found = [effectivity(count, *wave) for count in (8, 16, 32)]
    assert found == pytest.approx([1, 1, 1], abs=0.3)
    assert abs(found[2] - 1) < 0.05


def test_what_varies_through_the_layers_alone_is_no_error_in_the_plane():
    stack = {"layers": 3, "divisions": [4, 4], "through": 2}
    _, recovery, low, high, _ = spaces(Scene.from_table({"duration": "1 s", "stack": stack}))
    assert recovery.squares((100 * (low + high)[:, 2]) ** 2).max(initial=0.0) < 1e-24


def test_cells_stand_on_each_other_within_a_layer_alone():
    scene = Scene.from_table({"duration": "1 s", "stack": {"layers": 2, "divisions": [3, 2], "through": 3}})
    mesh, _, low, high, _ = spaces(scene)
    scalars = fem.functionspace(mesh.mesh, ("Lagrange", 1))
    upright, points = Upright.of(scalars), scalars.tabulate_dof_coordinates()
    heights = points[:, 2]
    assert (heights[upright.upper] - heights[upright.lower] == pytest.approx(2e-3 / 3, rel=1e-9)) or not len(low)
    assert np.abs(points[upright.upper][..., :2] - points[upright.lower][..., :2]).max(initial=0.0) < 1e-12
    within = np.flatnonzero(upright.above != NONE)
    assert np.array_equal(within, np.flatnonzero(np.abs(high[:, 2] % 2e-3 - 1e-3) < 0.5e-3))
    assert np.allclose(low[upright.above[within]][:, 2], high[within, 2])
    assert np.array_equal(upright.below[upright.above[within]], within)


def test_a_finer_mesh_has_a_smaller_estimate(table, folder):
    """Under a roller, as every run tells."""
    estimates = []
    for finer in (1, 2, 4):
        stack = table["stack"] | {"divisions": [6 * finer, 1], "through": finer}
        result = run(Scene.from_table(table | {"stack": stack}), folder / str(finer))
        estimates.append(result.history[-1]["vf_error"])
    assert 0.02 < estimates[2] < estimates[1] < estimates[0] < 0.5


def test_with_bending_one_element_through_a_layer_is_no_error(table, folder):
    """It is the model then: only the plane counts."""
    laws = table.get("laws", {}) | {"bending": {"modulus": "0.1 GPa"}}
    rows = [
        run(Scene.from_table(t), folder / str(n)).history[-1] for n, t in enumerate((table, table | {"laws": laws}))
    ]
    assert rows[0]["vf_error"] > 1.5 * rows[0]["vf_error_in_plane"] > 0
    assert rows[1]["vf_error"] == rows[1]["vf_error_in_plane"] > 0


def test_an_even_pressure_has_no_error(folder):
    """A flat plate on one layer without weight: no cell shows less than there is."""
    tool = {"kind": "plate", "path": [{"travel": ["0 mm", "0 mm", "-0.4 mm"], "speed": "1 mm/min"}]}
    stack = {"layers": 2, "size": ["4 mm", "4 mm"], "divisions": [2, 2], "through": 2}
    scene = Scene.from_table({"gravity": "0 m/s^2", "stack": stack, "tool": tool})
    assert run(scene, folder).history[-1]["vf_error"] < 1e-6


def test_the_estimate_is_near_the_error_of_layers_with_one_element_and_with_two(folder):
    """Under the roller of a strip, against the same with eight elements through each layer."""
    strip = ["stack.sides.y_max=symmetry", "stack.size=['30 mm', '1 mm']", "laws.shear.modulus=2 MPa"]
    stiff = ["tool.penalty=1e11 Pa/m", "interface.penalty=1e10 Pa/m", "output.picture=false", "output.report=false"]
    fields = {}
    for through in (1, 2, 8):
        mesh = ["stack.divisions=[20, 1]", f"stack.through={through}"]
        scene = Scene.read("demos/long_roller.toml", strip + stiff + mesh)
        result = run(scene, folder / str(through))
        COMM.barrier()
        fields[through] = VfField(folder / str(through)), result.history[-1]["vf_error"]
    rest = scene.stack.initial_volume_fraction
    found = {count: fields[count][1] / fields[count][0].off(fields[8][0], rest) for count in (1, 2)}
    assert 0.5 < found[1] < 2
    assert 0.7 < found[2] < 1.4


def test_what_stays_of_a_profile_after_the_tool_has_lifted_is_seen(table, folder):
    """Unloading goes by the largest Vf of each face, also where a run is restarted between."""
    path = [*table["tool"]["path"], {"travel": ["0 mm", "0 mm", "0.4 mm"], "speed": "2 mm/min"}]
    laws = {"unloading": {"kind": "permanent_set"}, "shear": {"modulus": "2 MPa"}}
    pressed = Scene.from_table(table | {"laws": laws})
    lifted = Scene.from_table(table | {"laws": laws, "tool": table["tool"] | {"path": path}})
    whole = run(lifted, folder / "whole").history
    run(pressed, folder / "in_two")
    row = run(lifted, folder / "in_two", restart=True).history[-1]
    assert row["tool_force"] == 0.0
    assert row["vf_error"] > 1.5 * row["vf_error_in_plane"]
    assert row["vf_error"] == pytest.approx(whole[-1]["vf_error"], rel=1e-6)


def test_both_faces_of_an_interface_have_one_pressure(table, folder):
    """What the upper face is told by forces is what the lower one has, where their nodes face each other."""
    simulation = Simulation(Scene.from_table(table), folder, COMM, overwrite=False)
    simulation.run()
    problem = simulation.problem
    scalars, upright = problem.contacts.body.spaces.scalars, Upright.of(problem.contacts.body.spaces.scalars)
    pressures = simulation.measures.contacts.nodes["contact_pressure"]
    found = FacePressures(problem, upright).at_nodes(pressures)
    points = scalars.tabulate_dof_coordinates()
    lower = np.unique(upright.upper[(upright.above == NONE) & (problem.stack.layer == 0)])
    upper = np.unique(upright.lower[(upright.below == NONE) & (problem.stack.layer == 1)])
    order = [nodes[np.lexsort(points[nodes].round(9).T)] for nodes in (lower, upper)]
    below, above = (found[nodes] for nodes in order)
    largest = COMM.allreduce(below.max(initial=0.0), MPI.MAX)
    assert largest > 100
    assert np.abs(above - below).max(initial=0.0) < 0.05 * largest
