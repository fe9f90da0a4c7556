"""An isotropic block under a rigid cylinder, side by side with general codes: time, memory and error in force.

Run on the machine itself, not in the container: ``python3 demos/verification/general_codes.py``. CalculiX takes part
where it is installed (Debian: ``apt-get install calculix-ccx``), FElupe with ``--felupe general/bin/python`` after
``python3 -m venv general && general/bin/pip install "felupe[all]==11.3" pypardiso``. All codes have the same law,
penalty, ten steps and tolerance, and may use all cores. Times are those of whole programs, start and files included;
that of this program's container, measured beside it, is taken off.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
BLOCK: dict[str, Any] = {  # a quarter, in mm and MPa
    "size": [30.0, 15.0, 8.0],
    "divisions": [120, 12, 16],
    "radius": 2.5,
    "modulus": 1.0,
    "poisson": 0.2,
    "travel": 0.5,
    "steps": 10,
    "penalty": 100.0,
    "tolerance": 1e-6,
}
SCENE = """title = "Block under a cylinder"
gravity = "0 m/s^2"
[laws.solid]
kind = "split"
modulus = "{modulus} MPa"
poisson = {poisson}
volume_integration = "full"  # as the other codes
[stack]
layers = {layers}
thickness = "{thickness} mm"
size = ["{size[0]} mm", "{size[1]} mm"]
divisions = {divisions}
through = {through}
grading = {grading}
[interface]
kind = "bonded"
[tool]
radius = "{radius} mm"
width = "infinite"
penalty = "{pascal_per_metre} Pa/m"
[[tool.path]]
travel = ["0 mm", "0 mm", "-{travel} mm"]
speed = "1 mm/min"
[solver]
first_step = "{step} s"
largest_step = "{step} s"
force_tolerance = {tolerance}
factors = "{factors}"
[output]
picture = false
report = false
fields_every = 1000
"""
SAME = {"divisions": [120, 12], "through": [16], "grading": [0.0, 0.0], "factors": "multigrid"}
OWN = {"divisions": [64, 2], "through": [3, 3, 6, 10], "grading": [0.7, 0.0], "factors": "multigrid"}
FINE = {"divisions": [160, 4], "through": [4, 6, 10, 20], "grading": [0.6, 0.0], "factors": "multigrid"}
QUARTERS = 4


def coarser(mesh: dict[str, Any], by: int) -> dict[str, Any]:
    """A mesh with fewer elements each way."""
    counts = {key: [max(count // by, 1) for count in mesh[key]] for key in ("divisions", "through") if key in mesh}
    return mesh | counts


def this_program(mesh: dict[str, Any], ranks: int, folder: Path) -> dict[str, float]:
    """Run the block with a mesh; force on the quarter in N, iterations, seconds and MB."""
    layers = len(mesh["through"])
    more = {
        "layers": layers,
        "thickness": BLOCK["size"][2] / layers,
        "pascal_per_metre": BLOCK["penalty"] * 1e9,
        "step": 60 * BLOCK["travel"] / BLOCK["steps"],
    }
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / "block.toml"
    scene.write_text(SCENE.format(**BLOCK | mesh | more), encoding="utf-8")
    busy = ["env", "OMPI_MCA_mpi_yield_when_idle=0"]  # nothing else runs here
    command = [str(HERE.parents[1] / "docker" / "run"), *busy, "mpirun", "-n", str(ranks), "ncf-fenicsx"]
    start = time.perf_counter()
    subprocess.run([command[0], "true"], check=True, capture_output=True)
    container, start = time.perf_counter() - start, time.perf_counter()
    run = subprocess.run(
        [*command, "run", str(scene), "--out", str(folder / "results"), "--overwrite"],
        check=False,
        capture_output=True,
        text=True,
    )
    seconds = time.perf_counter() - start - container
    if run.returncode:
        raise SystemExit(run.stdout + run.stderr)
    record = json.loads((folder / "results" / "run.json").read_text("utf-8"))
    heading, *_, last = (folder / "results" / "history.csv").read_text("utf-8").splitlines()
    force = dict(zip(heading.split(","), last.split(","), strict=True))["tool_force"]
    return {
        "force": float(force) / QUARTERS,
        "iterations": record["newton_iterations"],
        "seconds": seconds,
        "memory": record["peak_memory_mb"],
    }


def other(program: str, script: str, block: dict[str, Any], folder: Path) -> dict[str, float]:
    """Run another code's script with the block; the same figures."""
    folder.mkdir(parents=True, exist_ok=True)
    given, out = folder / "block.json", folder / "other.json"
    modulus, poisson = block["modulus"], block["poisson"]
    moduli = {"shear_modulus": modulus / (2 * (1 + poisson)), "bulk_modulus": modulus / (3 * (1 - 2 * poisson))}
    given.write_text(json.dumps(block | moduli), encoding="utf-8")
    start = time.perf_counter()
    with out.open("w") as file:
        process = subprocess.Popen([program, str(HERE / script), str(given)], stdout=file)
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{script} failed")
    answer: dict[str, float] = json.loads(out.read_text("utf-8"))
    return answer | {"seconds": time.perf_counter() - start, "memory": usage.ru_maxrss / 1024}


def table(runs: dict[str, dict[str, float]], reference: float) -> str:
    """The runs as a Markdown table, with errors in force to a reference (N)."""
    slowest = max(run["seconds"] for run in runs.values())
    lines = ["| code | force, N | error | iterations | s | GB | times as fast |", "|---|---|---|---|---|---|---|"]
    for name, run in runs.items():
        error = 100 * abs(run["force"] / reference - 1)
        lines.append(
            f"| {name} | {run['force']:.5f} | {error:.2f} % | {run['iterations']:.0f} | {run['seconds']:.1f} "
            f"| {run['memory'] / 1024:.2f} | {slowest / run['seconds']:.1f} |"
        )
    return "\n".join(lines)


def options() -> argparse.ArgumentParser:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--felupe", help="Python that has FElupe; left out unless given")
    parser.add_argument("--coarse", type=int, default=1, help="divide the number of elements each way, to try it out")
    parser.add_argument("--ranks", type=int, default=os.cpu_count(), help="ranks of this program")
    parser.add_argument("--out", type=Path, default=Path("results/general_codes"), help="folder for results")
    return parser


def main() -> None:
    """Run all, print the table."""
    chosen = options().parse_args()
    block, runs = coarser(BLOCK, chosen.coarse), {}
    if chosen.felupe:
        runs["FElupe"] = other(chosen.felupe, "general_codes_felupe.py", block, chosen.out / "felupe")
    if shutil.which("ccx"):
        runs["CalculiX"] = other(sys.executable, "general_codes_calculix.py", block, chosen.out / "calculix")
    for name, mesh in {"same mesh": SAME, "own mesh": OWN, "reference": FINE}.items():
        folder = chosen.out / name.replace(" ", "_")
        runs[f"ncf_fenicsx, {name}"] = this_program(coarser(mesh, chosen.coarse), chosen.ranks, folder)
    print(f"{platform.machine()}, {os.cpu_count()} cores\n")
    print(table(runs, runs["ncf_fenicsx, reference"]["force"]))


if __name__ == "__main__":
    main()
