"""Where the paper's Eq. 1, as printed, loses stability, and which term takes it: ``python3 demos/as_printed.py``.

A strip of one layer is compacted evenly, a little more each time. The eigenvalue of its tangent with the lowest real
part, y K x / (y x) with its left and right vectors, is split into what the fibres' law gives and what all the rest
gives. Ends with an error where the printed law does not lose stability once lambda times the compaction passes G_t.
"""

import sys
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy.linalg import eig

from ncf_fenicsx import Scene
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.solver.timing import Phases

Floats = NDArray[np.float64]
Case = tuple[Problem, Newton]

MODULUS, POISSON, SHEAR = 242e9, 0.2, 2e6  # Pa, 1, Pa: those of demos/roller.toml
LAME = MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
CRITICAL = SHEAR / LAME
SHARES = (0.0, 0.5, 0.9, 1.1, 1.5, 2.0, 5.0)
"""Compactions over the one at which lambda times it is G_t."""


def strip(kind: str, modulus: float = MODULUS) -> Case:
    """Problem and solver of a strip of 24 x 2 x 2 mm, 24 elements long."""
    in_plane = {"kind": kind, "modulus": f"{modulus} Pa", "poisson": POISSON}
    table = {
        "stack": {"layers": 1, "size": ["24 mm", "2 mm"], "divisions": [24, 1], "grading": [0, 0]},
        "laws": {"in_plane": in_plane, "shear": {"modulus": f"{SHEAR} Pa"}},
        "duration": "1 s",
        "solver": {"tangent": "plain"},
    }
    scene = Scene.from_table(table)
    problem = Problem(scene, build_mesh(scene, MPI.COMM_SELF))
    return problem, Newton(problem, scene.solver, Phases())


def tangent(case: Case, compaction: float) -> Floats:
    """Tangent in N/m of the free dofs under an even compaction."""
    problem, newton = case
    problem.displacement.interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], -compaction * x[2]]))
    dense: Any = newton.tangent.assemble().copy()
    dense.convert("dense")
    free = np.setdiff1d(np.arange(dense.getSize()[0]), problem.supports.dofs)
    matrix: Floats = dense.getDenseArray()[np.ix_(free, free)]
    return matrix


def main() -> None:
    """Print a line for each compaction."""
    printed, meant, rest = strip("as_printed"), strip("neo_hookean"), strip("as_printed", modulus=1.0)
    print(f"lambda = {LAME / 1e9:.1f} GPa, G_t = {SHEAR / 1e6:g} MPa: G_t / lambda = {100 * CRITICAL:.5f} %")
    print("compaction     lowest eigenvalue (N/m)    as printed, in its mode (N/m)")
    print("               as meant     as printed    fibres       all the rest")
    for share in SHARES:
        compaction = share * CRITICAL
        values, left, right = eig(tangent(printed, compaction), left=True)
        lowest = int(values.real.argmin())
        y, x = left[:, lowest].real, right[:, lowest].real
        others = float(y @ tangent(rest, compaction) @ x / (y @ x))
        value, sound = float(values[lowest].real), float(np.linalg.eigvalsh(tangent(meant, compaction))[0])
        print(f"{100 * compaction:9.5f} %   {sound:9.4g}    {value:9.4g}     {value - others:10.4g}   {others:9.4g}")
        if (value < 0) != (share > 1):
            sys.exit("as_printed: expected stability to be lost where lambda times the compaction passes G_t")


if __name__ == "__main__" and MPI.COMM_WORLD.rank == 0:
    main()
