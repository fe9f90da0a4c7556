"""The roller scene by every way of enforcing contact.

Run: ``docker/run python3 demos/verification/enforcement.py [RESULTS_FOLDER] [WAY ...] [KEY=VALUE ...]``

All ways are run, or those that are named, as ``"Nitsche, incomplete"``, beside the augmented Lagrangian.

Prints force, penetration, iterations and time of each, and writes them to ``enforcement.csv`` in the folder. Ends with
an error if two forces differ by more than 0.5 %, or the augmented Lagrangian penetrates by over 1e-4 of a layer.
"""

import csv
import json
import sys
from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.study.machine import machine

WAYS = {
    "penalty, factors 1000 and 10 (default)": [],
    "penalty, factors 10000 and 1000": ["tool.penalty=1e4", "interface.penalty=1e3"],
    "augmented Lagrangian": ["tool.contact.kind=augmented_lagrangian", "interface.contact.kind=augmented_lagrangian"],
    "Nitsche, incomplete": ["tool.contact.kind=nitsche", "interface.contact.kind=nitsche"],
    "Nitsche, skew": [f"{face}.contact={{kind='nitsche', variant='skew'}}" for face in ("tool", "interface")],
    "Nitsche, symmetric": [f"{face}.contact={{kind='nitsche', variant='symmetric'}}" for face in ("tool", "interface")],
}
LARGEST_DIFFERENCE, LARGEST_PENETRATION = 0.005, 1e-4
EXACT = "augmented Lagrangian"
UM = 1e6


def measured(way: str, folder: Path, overrides: list[str]) -> dict[str, float | str]:
    """One row of the table."""
    scene = Scene.read(Path(__file__).parents[1] / "roller.toml", [*overrides, *WAYS[way]])
    result = run(scene, folder, overwrite=True)
    last = result.history[-1]
    between = max(value for name, value in last.items() if name.startswith("interface_penetration_max"))
    record = json.loads((folder / "run.json").read_text()) if MPI.COMM_WORLD.rank == 0 else {}
    record = MPI.COMM_WORLD.bcast(record)
    return {
        "way": way,
        "reached_s": last["time"],
        "force_N": last["tool_force"],
        "penetration_of_tool_um": UM * last["penetration_max"],
        "penetration_between_layers_um": UM * between,
        "iterations": record["newton_iterations"],
        "cuts": record["step_cuts"],
        "seconds": record["seconds_total"],
    }


def main(folder: Path, words: list[str]) -> int:
    """Run the ways that words name, or all; how many break their limit."""
    overrides = [word for word in words if "=" in word]
    ways = {EXACT, *words} - set(overrides) if len(overrides) < len(words) else set(WAYS)
    if ways - set(WAYS):
        sys.exit(f"{', '.join(sorted(ways - set(WAYS)))}: no such way; expected some of: {'; '.join(WAYS)}")
    chosen = [(number, way) for number, way in enumerate(WAYS) if way in ways]
    rows = [measured(way, folder / f"way_{number}", overrides) for number, way in chosen]
    exact = next(row for row in rows if row["way"] == EXACT)
    thickness = Scene.read(Path(__file__).parents[1] / "roller.toml", overrides).stack.thickness
    broken = sum(abs(row["force_N"] / exact["force_N"] - 1) > LARGEST_DIFFERENCE for row in rows)
    deepest = max(exact["penetration_of_tool_um"], exact["penetration_between_layers_um"]) / UM
    broken += deepest > LARGEST_PENETRATION * thickness
    if MPI.COMM_WORLD.rank == 0:
        with (folder / "enforcement.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
        print(machine())
        for row in rows:
            difference = 100 * (row["force_N"] / exact["force_N"] - 1)
            values = [f"{value:10.4g}" for name, value in row.items() if name != "way"]
            print(f"{row['way']:40s} {difference:+6.2f} %", *values)
    return broken


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/enforcement")
    sys.exit(main(folder, sys.argv[2:]))
