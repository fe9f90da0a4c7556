"""Scenes with friction that slide, lift off and snap, on several numbers of ranks: whether each has one history.

Run: ``docker/run python3 demos/verification/one_history.py [--scene NAME ...] [--ranks 1,2,3] [--out FOLDER]``

Each line has the steps and iterations of a scene, and the largest difference of the tool's force from that on the first
number of ranks, over its largest. A run that is done is not run again.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import numpy as np

from ncf_fenicsx.report.reading import Results

DEMOS = Path(__file__).parents[1]
QUIET = ["output.picture=false", "output.report=false", "output.fields_every=1000000"]
FOOT = [
    "stack={layers=1, thickness='0.5 mm', areal_density='356.25 g/m^2', size=['70 mm', '20 mm'], divisions=[70, 16], "
    "grading=[0.0, 0.0], sides={x_min='free', x_max='fixed', y_min='symmetry', y_max='free'}}",
    "tool.size=['10 mm', '20 mm']",
    "tool.path.0.travel=['0 mm', '0 mm', '-0.2 mm']",
]
"""A foot 20 mm wide on half of a free sheet: it buckles in both directions, and snaps."""
SCENES = {
    "wrinkle": ("wrinkle", []),
    "wrinkle, 1 mm": ("wrinkle", ["stack.divisions=[80, 1]"]),
    "figure_1": ("figure_1", []),
    "wide foot, plies": ("wrinkle", [*FOOT, "laws.in_plane={kind='fibre_families', plies=[0.0, 90.0]}"]),
    "wide foot": ("wrinkle", FOOT),
}
"""File and changes by name."""


def run_on(ranks: int, name: str, folder: Path) -> Results:
    """Results of a scene on so many ranks.

    Raises:
        SystemExit: it stopped.
    """
    file, changes = SCENES[name]
    own = folder / f"{name.replace(', ', '_').replace(' ', '_')}_{ranks}"
    if not (own / "run.json").is_file():
        words = [word for change in [*changes, *QUIET] for word in ("--set", change)]
        start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        program = [*start, "ncf-fenicsx", "run", str(DEMOS / f"{file}.toml"), *words, "--out", str(own), "--overwrite"]
        if subprocess.run([*program, *([] if start else ["--ranks", "1"])], stdout=subprocess.DEVNULL).returncode:
            sys.exit(f"{name} on {ranks} ranks stopped: see {own}")
    return Results.read(own)


def main() -> None:
    """Run, compare, print."""
    options = argparse.ArgumentParser()
    options.add_argument("--scene", action="append", choices=list(SCENES), help="one of the scenes; all unless given")
    options.add_argument("--ranks", default="1,2,3", help="numbers of ranks, with commas")
    options.add_argument("--out", type=Path, default=Path("results/one_history"))
    asked = options.parse_args()
    for name in asked.scene or SCENES:
        first = None
        for ranks in map(int, asked.ranks.split(",")):
            results = run_on(ranks, name, asked.out)
            history, record = results.history, results.record
            first = first or history
            line = f"{name}, on {ranks}: {len(history['time'])} rows, {record['newton_iterations']} iterations"
            if len(history["time"]) != len(first["time"]) or not np.allclose(history["time"], first["time"], rtol=1e-9):
                print(f"{line}; other steps", flush=True)
                continue
            off = np.abs(history["tool_force"] - first["tool_force"]) / np.abs(first["tool_force"]).max()
            print(f"{line}; off by {off.max():.0e}, by {off[-1]:.0e} at the end", flush=True)


if __name__ == "__main__":
    main()
