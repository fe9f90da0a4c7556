"""A roller on rubber: force over Poisson's ratio, element and rule of integration.

Run: ``docker/run python3 demos/verification/incompressible.py [POISSON ...]``; prints a table, in some ten minutes for
all four ratios. Full integration locks towards 0.5, the reduced one of the change of volume does not. With
``--multigrid`` it prints what multigrid takes in place of factors, on 20 x 8 x 8 elements.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from ncf_fenicsx import Scene, run

RATIOS = (0.3, 0.49, 0.499, 0.4999)
MESHES = ((20, 6), (40, 12), (80, 24))
"""Elements along and through the block."""


def block(poisson: float, divisions: int, through: int, **solid: Any) -> dict[str, Any]:
    """Scene of the roller on the block, the same contact at any Poisson's ratio; more keys of its law."""
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


def force(order: int, mesh: tuple[int, int], poisson: float, rule: str) -> float:
    """Force in N at the end of the path; nan where the run stops before."""
    table = block(poisson, *mesh, volume_integration=rule)
    table["stack"]["order"] = order
    with tempfile.TemporaryDirectory() as folder:
        result = run(Scene.from_table(table), folder, overwrite=True)
    return result.history[-1]["tool_force"] if result.done else float("nan")


def krylov_steps(poisson: float) -> tuple[int, float]:
    """Krylov steps of multigrid over the path, and the force in N at its end."""
    table = block(poisson, 20, 8)
    table["stack"]["divisions"] = [20, 8]
    table["solver"] = {"factors": "multigrid"}
    with tempfile.TemporaryDirectory() as folder:
        result = run(Scene.from_table(table), folder, overwrite=True)
        record = json.loads((Path(folder) / "run.json").read_text("utf-8"))
    return record["krylov_steps"], result.history[-1]["tool_force"]


def tell_forces(ratios: list[float]) -> None:
    """Print the table of forces."""
    print("nu, rule, force in N with order 1 and 2 on", ", ".join(f"{along} x {through}" for along, through in MESHES))
    for poisson in ratios:
        for rule in ("reduced", "full"):
            forces = [force(order, mesh, poisson, rule) for order in (1, 2) for mesh in MESHES]
            print(poisson, rule, *(f"{value:.4f}" for value in forces), flush=True)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ratios", nargs="*", type=float, default=RATIOS, help="Poisson's ratios")
    parser.add_argument("--multigrid", action="store_true", help="count the Krylov steps of multigrid")
    chosen = parser.parse_args()
    if not chosen.multigrid:
        tell_forces(chosen.ratios)
        return
    print("nu, Krylov steps, force in N")
    for poisson in chosen.ratios:
        steps, load = krylov_steps(poisson)
        print(f"{poisson} {steps} {load:.4f}", flush=True)


if __name__ == "__main__":
    main()
