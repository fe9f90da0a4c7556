"""What the laws cost: assembly of the tangent by hexahedron, and compilation of the forms, as ratios within one run."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from mpi4py import MPI

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.report.reading import read_record
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.solver import Newton
from ncf_fenicsx.solver.timing import Phases
from ncf_fenicsx.study.machine import machine

REPEATS = 7
LAWS: dict[str, dict[str, Any]] = {
    "neo-Hookean solid": {"solid": {}},
    "fabric, default laws": {},
    "with the speed of the process": {"rate": {"feed": "process"}},
    "with unloading": {"unloading": {}},
    "with two relaxing branches": {"relaxation": {"branches": [{}, {"time": "100 s"}]}},
    "with bending apart": {"bending": {}},
    "with fibre families of seven plies": {"in_plane": {"kind": "fibre_families"}},
    "with fibres as printed": {"in_plane": {"kind": "as_printed"}},
}


def benchmark(divisions: int) -> str:
    """Markdown tables of what was measured on this machine.

    Args:
        divisions: elements along x and y of each of four layers.

    Raises:
        SceneError: on several ranks, which would disturb each other.
    """
    if MPI.COMM_WORLD.size > 1:
        raise SceneError(f"benchmark: on {MPI.COMM_WORLD.size} ranks; expected one, without mpirun")
    microseconds = {name: assembly(laws, divisions) for name, laws in LAWS.items()}
    cold, warm = compilation()
    solid = microseconds["neo-Hookean solid"]
    rows = [f"| {name} | {value:.1f} | {value / solid:.2f} |" for name, value in microseconds.items()]
    return "\n".join(
        [
            f"{machine()}; one rank, {4 * divisions**2} hexahedra, best of {REPEATS}",
            "",
            "| tangent of | us a hexahedron | over the solid's |",
            "|---|---|---|",
            *rows,
            "",
            "| forms of the roller scene | s |",
            "|---|---|",
            f"| compiled | {cold:.2f} |",
            f"| read back | {warm:.2f} |",
        ]
    )


def assembly(laws: dict[str, Any], divisions: int) -> float:
    """Least time in microseconds to assemble the tangent of a bonded stack, by hexahedron."""
    stack = {"divisions": [divisions, divisions], "grading": [0.0, 0.0]}
    table = {"duration": "1 s", "gravity": "0 m/s^2", "stack": stack, "interface": {"kind": "bonded"}, "laws": laws}
    scene = Scene.from_table(table)
    problem = Problem(scene, build_mesh(scene, MPI.COMM_SELF))
    newton = Newton(problem, scene.solver, Phases())
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        newton.tangent.assemble()
        seconds.append(time.perf_counter() - start)
    return 1e6 * min(seconds) / (4 * divisions**2)


def compilation() -> tuple[float, float]:
    """Seconds that a program of its own spends on the roller's forms with an empty cache, and with a full one."""
    with tempfile.TemporaryDirectory() as folder:
        cold, warm = (_forms_seconds(Path(folder)) for _ in range(2))
    return cold, warm


def _forms_seconds(folder: Path) -> float:
    scene = folder / "roller.toml"
    scene.write_text(
        "[tool]\n[stack]\ndivisions = [2, 2]\n[solver]\nmax_steps = 1\n[output]\npicture = false\nreport = false\n"
    )
    command = [sys.executable, "-m", "ncf_fenicsx", "run", str(scene), "--overwrite", "--out", str(folder / "out")]
    environment = os.environ | {"XDG_CACHE_HOME": str(folder / "cache")}
    subprocess.run(command, env=environment, capture_output=True, check=False)
    return float(read_record(folder / "out")["seconds"]["forms"])
