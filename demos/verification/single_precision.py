"""Factors in single precision against double: time, memory, and how a solution is corrected by FGMRES.

Run: ``docker/run --dolfinx 0.11 python3 demos/verification/single_precision.py [N ...]``; PETSc 3.25 has the option,
3.22 has not. The tangent is that of the roller scene at rest, with a bending modulus of 0.1 GPa, on meshes of N x N.

Memory is MUMPS' own figure, times are the processor's. GMRES would not do: it applies the factors once more to the
sum of its steps, and single precision leaves 1e-2 of the residual of a matrix with fibres of 242 GPa there.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ncf_fenicsx import Scene
from ncf_fenicsx.simulation.simulation import Simulation
from ncf_fenicsx.solver.direct_factors import SPARE

DEMOS = Path(__file__).parents[1]
SIZES = (20, 41, 60)
MEMORY, NEGATIVE = 19, 12
"""MUMPS' numbers of what it says of factors."""
TOLERANCE = 1e-8


def tangent(count, folder):
    """The matrix, and a load of random forces on the dofs that are free."""
    changes = [f"stack.divisions=[{count}, {count}]", "stack.grading=[0, 0]", "laws.bending.modulus='0.1 GPa'"]
    simulation = Simulation(Scene.read(DEMOS / "roller.toml", changes), folder, MPI.COMM_WORLD, overwrite=True)
    matrix = simulation.newton.tangent.assemble()
    load = matrix.createVecLeft()
    load.array[:] = np.random.default_rng(0).standard_normal(load.getLocalSize())
    load.array[simulation.problem.supports.dofs] = 0.0
    return matrix, load


def measured(matrix, load, precision):
    """One line on factors of a precision."""
    options = PETSc.Options()
    options["mixed_pc_precision"] = precision
    options["mixed_mat_mumps_icntl_14"] = SPARE
    solver = PETSc.KSP().create()
    solver.setOptionsPrefix("mixed_")
    solver.setOperators(matrix)
    solver.setType("fgmres")
    solver.setTolerances(rtol=TOLERANCE)
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
    solver.setFromOptions()
    times = [time.process_time()]
    solver.setUp()
    times.append(time.process_time())
    found = load.duplicate()
    solver.solve(load, found)
    times.append(time.process_time())
    factors, residual = solver.getPC().getFactorMatrix(), (matrix * found - load).norm() / load.norm()
    assert residual < 2 * TOLERANCE, residual
    pieces = np.diff(times)
    return (
        f"{precision}: factors {pieces[0]:.2f} s, {factors.getMumpsInfog(MEMORY)} MB, "
        f"{factors.getMumpsInfog(NEGATIVE)} negative pivots; solution {pieces[1]:.2f} s, "
        f"{solver.getIterationNumber()} steps to {residual:.0e}"
    )


if __name__ == "__main__":
    for size in map(int, sys.argv[1:] or SIZES):
        with tempfile.TemporaryDirectory() as place:
            assembled = tangent(size, Path(place) / "run")
        print(f"{size} x {size}, {assembled[0].size[0]} unknowns")
        for name in ("double", "single"):
            print(f"  {measured(*assembled, name)}")
