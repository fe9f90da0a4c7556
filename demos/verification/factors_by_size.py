"""From what size on factors of layers beat those of the whole.

Run: ``docker/run python3 demos/verification/factors_by_size.py [RESULTS_FOLDER] [OPTIONS]``

Runs the roller scene with a bending modulus of 0.1 GPa on even meshes of N x N elements a layer: with new factors at
every iteration, kept ones, and those of layers. Prints time and memory, writes them to ``factors_by_size.csv`` in the
folder and draws both. Ends with an error if two forces on one mesh differ by more than 0.01 %.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt

from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.study.machine import machine
from ncf_fenicsx.workers.launch import BARE, launch

SCENE = Path(__file__).parents[1] / "roller.toml"
SET = ("stack.grading=[0, 0]", "laws.bending.modulus=0.1 GPa", "solver.force_tolerance=1e-4", *BARE)
WAYS = {"new": "of the whole, new", "kept": "of the whole, kept", "layers": "of layers"}
LARGEST_DIFFERENCE = 1e-4


def measured(factors: str, elements: int, ranks: int, folder: Path) -> dict[str, Any]:
    """One row of the table."""
    overrides = (f"stack.divisions=[{elements}, {elements}]", f"solver.factors={factors}", *SET)
    ended = launch(SCENE, folder / f"{factors}_{elements}", overrides, 7200, ranks=ranks)
    if ended.ending != "done":
        sys.exit(f"{factors}, {elements} x {elements}: {ended.reason}")
    record = ended.record
    return {
        "factors": factors,
        "elements": elements,
        "unknowns": record["unknowns"],
        "ranks": ranks,
        "seconds": round(record["seconds_total"] - record["seconds"]["forms"], 2),
        "memory_gb": round(record["peak_memory_mb"] / 1024, 3),
        "iterations": record["newton_iterations"],
        "factorisations": record["factorisations"],
        "krylov_steps": record["krylov_steps"],
        "force_N": float(read_history(ended.folder / "history.csv")["tool_force"][-1]),
    }


def draw(rows: list[dict[str, Any]], file: Path) -> None:
    """Time and memory over the number of unknowns, a line for each way."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for column, label, panel in (("seconds", "run (s)", axes[0]), ("memory_gb", "peak memory (GB)", axes[1])):
        for factors, name in WAYS.items():
            own = [row for row in rows if row["factors"] == factors]
            panel.loglog([row["unknowns"] for row in own], [row[column] for row in own], "o-", label=f"factors {name}")
        panel.set(xlabel="unknowns", ylabel=label)
        panel.grid(alpha=0.3)
    axes[0].legend()
    figure.suptitle(f"Roller on four layers, {rows[0]['ranks']} ranks, {machine()}")
    figure.savefig(file, dpi=120)


def main() -> int:
    """Run all; how many forces differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("results/factors_by_size"))
    parser.add_argument("--elements", type=int, nargs="+", default=[20, 29, 41, 58, 82])
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = []
    print(machine())
    for elements in given.elements:
        for factors in given.ways:
            rows.append(measured(factors, elements, given.ranks, given.folder))
            print(*(f"{name} {value}" for name, value in rows[-1].items()), sep=", ", flush=True)
    with (given.folder / "factors_by_size.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, given.folder / "factors_by_size.png")
    first = {row["elements"]: row["force_N"] for row in reversed(rows)}
    return sum(abs(row["force_N"] / first[row["elements"]] - 1) > LARGEST_DIFFERENCE for row in rows)


if __name__ == "__main__":
    sys.exit(main())
