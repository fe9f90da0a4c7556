"""Problems assembled for tests, and what is done with them."""

import json

import numpy as np
from dolfinx import fem, la
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mechanics.time_step import TimeStep
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.simulation.step import AT_REST
from ncf_fenicsx.solver import Newton, factor_choice
from ncf_fenicsx.solver.timing import Phases

COMM = MPI.COMM_WORLD


def build(table):
    scene = Scene.from_table(table)
    problem = Problem(scene, build_mesh(scene, COMM))
    return problem, Newton(problem, scene.solver, Phases())


def step_of(problem, newton=None):
    """Steps of a problem, solved by Newton's method."""
    return TimeStep(problem, lambda time, size, effort: newton.solve(effort if size else AT_REST))  # noqa: ARG005


def assign(problem, field):
    """Set the displacement (m) from a function of coordinates (3, points)."""
    problem.displacement.interpolate(field)


def bumpy(x):
    """A large, smooth displacement that closes some pairs, opens others and presses into the tool."""
    layer = np.where(x[2] > 2.05e-3, 1.0, 0.0)
    w = -2e-4 * np.cos(300 * x[0]) * (0.3 + x[2] / 4e-3) + 3e-5 * layer * np.sin(900 * x[0])
    return np.stack([2e-7 * np.sin(500 * x[2] + 200 * x[1]), 1e-7 * np.cos(400 * x[0]), w])


def gradient_error(problem, newton, step):
    """Relative difference of the tangent times a direction from the residual's central difference."""
    u = problem.displacement.x.array
    centre = u.copy()
    direction = fem.Function(problem.space)
    direction.interpolate(
        lambda x: np.stack([1e-3 * np.sin(300 * x[1]), 1e-3 * np.cos(200 * x[2]), np.sin(250 * x[0])])
    )
    d = direction.x.array
    d[problem.supports.dofs] = 0
    sides = []
    for sign in (1, -1):
        u[:] = centre + sign * step * d
        sides.append(newton.evaluate_residual())
    u[:] = centre
    difference = (sides[0] - sides[1]) / (2 * step)
    matrix = newton.tangent.assemble()
    x, y = newton.unknown.duplicate(), newton.unknown.duplicate()
    x.array[:] = d[: x.getLocalSize()]
    matrix.mult(x, y)
    free = np.setdiff1d(np.arange(y.getLocalSize()), problem.supports.dofs)
    error = COMM.allreduce(float(((y.array_r - difference)[free] ** 2).sum()))
    size = COMM.allreduce(float((difference[free] ** 2).sum()))
    return np.sqrt(error / size)


def run_with_factors(table, factors, folder):
    """Last row and record of a run of a roller on two layers."""
    table["stack"] |= {"size": ["30 mm", "6 mm"], "divisions": [30, 2]}
    table["solver"] = {"factors": factors}
    result = run(Scene.from_table(table), folder / factors)
    assert result.done, result.reason
    return result.history[-1], json.loads((result.folder / "run.json").read_text("utf-8"))


def forces(form):
    """Nodal forces in N of a residual term."""
    vector = fem.assemble_vector(form)
    vector.scatter_reverse(la.InsertMode.add)
    vector.scatter_forward()
    return vector.array.reshape(-1, 3).copy()


def layer_factors(newton):
    return factor_choice._factors(newton.system, "layers", newton.vector, newton._constrained)


def tangent_of(table):
    """The tangent where some of the layers touch, and a load whose solution is known."""
    problem, newton = build(table)
    assign(problem, bumpy)
    matrix = newton.tangent.assemble()
    wanted, load = newton.unknown.duplicate(), newton.unknown.duplicate()
    wanted.array[:] = problem.displacement.x.array[: wanted.getLocalSize()]
    wanted.array[newton._constrained] = 0.0
    matrix.mult(wanted, load)
    return newton, matrix, wanted, load
