"""The estimated error of a field of cell means against its true error."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.output.error_estimate import Recovery

COMM = MPI.COMM_WORLD
LENGTH = 8e-3


def effectivity(count, integral, square):
    """Estimated over true error of the cell means of a field of x, given its integral and that of its square."""
    stack = {"layers": 2, "size": [f"{LENGTH} m", "2 mm"], "divisions": [count, 2], "grading": [0, 0]}
    scene = Scene.from_table({"duration": "1 s", "stack": stack})
    mesh = build_mesh(scene, COMM)
    scalars = fem.functionspace(mesh.mesh, ("Lagrange", 1))
    cells = len(mesh.layer)
    h, positions = LENGTH / count, scalars.tabulate_dof_coordinates()[scalars.dofmap.list[:cells]]
    volumes = np.ptp(positions, axis=1).prod(axis=1)
    low, high = positions[:, :, 0].min(axis=1), positions[:, :, 0].max(axis=1)
    means = (integral(high) - integral(low)) / h
    estimated = Recovery(scalars, volumes).error(means, 0.0)
    true = ((square(high) - square(low)) / h - means**2) @ volumes
    true, change = COMM.allreduce(np.array([true, volumes @ means**2]))
    return estimated / np.sqrt(true / change)


def test_the_estimate_tends_to_the_true_error():
    """A wave whose cell means have a known error."""
    k = 2 * np.pi / LENGTH
    wave = (lambda x: -np.cos(k * x) / k, lambda x: x / 2 - np.sin(2 * k * x) / (4 * k))
    found = [effectivity(count, *wave) for count in (8, 16, 32)]
    assert found == pytest.approx([1, 1, 1], abs=0.3)
    assert abs(found[2] - 1) < 0.05


def test_an_even_field_has_no_error():
    scene = Scene.from_table({"duration": "1 s", "stack": {"divisions": [4, 4]}})
    mesh = build_mesh(scene, COMM)
    scalars = fem.functionspace(mesh.mesh, ("Lagrange", 1))
    recovery = Recovery(scalars, np.ones(len(mesh.layer)))
    assert recovery.error(np.full(len(mesh.layer), 0.5), 0.4) < 1e-14
    assert recovery.error(np.full(len(mesh.layer), 0.4), 0.4) == 0.0


def test_a_finer_mesh_has_a_smaller_estimate(table, folder):
    """Under a roller, as every run tells."""
    estimates = []
    for finer in (1, 2, 4):
        stack = table["stack"] | {"divisions": [6 * finer, 1], "through": finer}
        result = run(Scene.from_table(table | {"stack": stack}), folder / str(finer))
        estimates.append(result.history[-1]["vf_error"])
    assert 0.02 < estimates[2] < estimates[1] < estimates[0] < 0.3


def test_outer_faces_are_reached_by_a_parabola_and_nothing_else():
    """Cell means of z^2 through the layers give it exactly at the bottom and the top, and smoothed means between."""
    scene = Scene.from_table({"duration": "1 s", "stack": {"layers": 4, "divisions": [3, 2], "grading": [0, 0]}})
    mesh = build_mesh(scene, COMM)
    scalars = fem.functionspace(mesh.mesh, ("Lagrange", 1))
    cells, top = len(mesh.layer), 4 * scene.stack.thickness
    z = scalars.tabulate_dof_coordinates()[scalars.dofmap.list[:cells]][:, :, 2]
    low, high = z.min(axis=1), z.max(axis=1)
    smooth = Recovery(scalars, np.ptp(z, axis=1))._smooth((high**3 - low**3) / (3 * (high - low)))
    outer = (z < 1e-9) | (z > top - 1e-9)
    assert np.abs(smooth - z**2)[outer].max(initial=0.0) < 1e-12 * top**2
    assert np.abs(smooth - z**2)[~outer].min(initial=1.0) > 0.01 * scene.stack.thickness**2
