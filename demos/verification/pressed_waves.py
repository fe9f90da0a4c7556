"""Waves inside a pressed stack: with a bending stiffness they have a length of their own, without one that of the mesh.

Run: ``docker/run python3 demos/verification/pressed_waves.py [RESULTS_FOLDER]``

Presses two layers between a plane and a plate until they are compacted as under a tool, then shortens them until their
tangent has a mode without stiffness, on finer and finer elements. Prints the force per layer and the length of the
waves beside those of a sheet with shear on an elastic foundation, writes them to ``pressed_waves.csv`` and draws both.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from scipy.optimize import brentq

from ncf_fenicsx import Scene
from ncf_fenicsx.output.wrinkles import crossing_wavelength
from ncf_fenicsx.simulation import Simulation
from ncf_fenicsx.study.machine import machine

LENGTH, THICKNESS, SHEAR = 60e-3, 2e-3, "5 MPa"
DIVISIONS = (15, 30, 60, 120, 240)
LAWS: dict[str, dict[str, Any]] = {
    "bending modulus 1 MPa": {"bending": {"modulus": "1 MPa", "poisson": 0.0}},
    "no bending law": {},
}


def pressed(laws: dict[str, Any], divisions: int, folder: Path) -> Simulation:
    """A run that has pressed two layers by a quarter of their thickness."""
    scene = Scene.from_table(
        {
            "gravity": "0 m/s^2",
            "stack": {
                "layers": 2,
                "size": [f"{LENGTH} m", "1 mm"],
                "divisions": [divisions, 1],
                "grading": [0, 0],
                "sides": dict.fromkeys(("x_min", "x_max", "y_min", "y_max"), "symmetry"),
            },
            "laws": {"shear": {"modulus": SHEAR}, "rate": {"kind": "none"}} | laws,
            "tool": {"kind": "plate", "path": [{"travel": ["0 mm", "0 mm", "-1 mm"], "speed": "1 mm/min"}]},
            "output": {"picture": False, "report": False},
        }
    )
    simulation = Simulation(scene, folder / "pressed", MPI.COMM_WORLD, overwrite=True)
    result = simulation.run()
    if not result.done:
        sys.exit(result.reason)
    return simulation


def first_waves(simulation: Simulation) -> tuple[float, float]:
    """Strain along x at which the stack has a mode without stiffness, and the length of its waves in m."""
    problem, newton = simulation.problem, simulation.newton
    rest = problem.displacement.x.array.copy()
    x = problem.space.tabulate_dof_coordinates()

    def lowest(strain: float) -> tuple[float, Any]:
        problem.displacement.x.array[:] = rest
        problem.displacement.x.array.reshape(-1, 3)[:, 0] -= strain * x[:, 0]
        problem.contacts.refresh()
        found = newton.critical_mode()
        if found is None:
            sys.exit("the lowest mode is not found")
        return found

    high = 1e-9
    while lowest(high)[0] > 0:
        high *= 2
    strain = brentq(lambda strain: lowest(strain)[0], high / 2, high, rtol=1e-3)
    _, mode = lowest(strain)
    middle = np.isclose(x[:, 2], THICKNESS) & (x[:, 1] < 1e-9)
    places, first = np.unique(x[middle, 0].round(9), return_index=True)
    return strain, crossing_wavelength(places, mode[middle, 2][first])


def main(folder: Path) -> None:
    """Run all, print, write and draw."""
    rows = []
    for name, laws in LAWS.items():
        for divisions in DIVISIONS:
            strain, wavelength = first_waves(pressed(laws, divisions, folder))
            rows.append(
                {
                    "laws": name,
                    "element_mm": 1e3 * LENGTH / divisions,
                    "wavelength_mm": round(1e3 * wavelength, 4),
                    "strain": float(f"{strain:.5g}"),
                }
            )
            print(
                "{laws:24s} elements of {element_mm:6.3f} mm: waves of {wavelength_mm:7.3f} mm at {strain:.4g}".format(
                    **rows[-1]
                )
            )
    with (folder / "pressed_waves.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, folder / "pressed_waves.png")
    print(machine())


def draw(rows: list[dict[str, Any]], file: Path) -> None:
    """Length of the waves over that of the elements."""
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for name in LAWS:
        own = [row for row in rows if row["laws"] == name]
        axes.loglog([row["element_mm"] for row in own], [row["wavelength_mm"] for row in own], "o-", label=name)
    axes.loglog([0.25, 4], [0.5, 8], "k:", label="two elements")
    axes.set(xlabel="length of an element (mm)", ylabel="length of the first waves (mm)")
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/pressed_waves"))
