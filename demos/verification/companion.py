"""Errors told by a companion of half the mesh against true errors, and what the companion costs.

Run: ``docker/run python3 demos/verification/companion.py [--scene NAME ...] [--out FOLDER]``

The true error of a run is that against the same scene with a quarter of its elements' length and of its steps.
Prints a line for each quantity. What is in the folder already is not run again.
"""

import argparse
from pathlib import Path

from ncf_fenicsx import Scene, simulation
from ncf_fenicsx.accuracy.answer import Answer, Level
from ncf_fenicsx.accuracy.levels import Levels

DEMOS = Path(__file__).parents[1]
QUANTITIES = ("force", "vf", "void_volume")
SCENES = {
    "long_roller": ("long_roller", ["laws.shear.modulus=2 MPa"]),
    "deep, stable": ("deep", ["laws.shear.modulus=2 MPa"]),
    "relaxation": ("relaxation", ["solver.max_iterations=30"]),
}
"""File and changes by name."""
OWN, FINEST = 1, 3
"""Levels, counted from the companion's: that of the scene itself, and that of the reference."""


def levels_of(name: str, folder: Path) -> list[Level]:
    """The companion, the scene itself and its reference, run where they are not done yet.

    Raises:
        SystemExit: one of them stops.
    """
    file, changes = SCENES[name]
    quiet = ["output.picture=false", "output.report=false", "output.fields_every=1000000"]
    levels, found = Levels(Scene.read(DEMOS / f"{file}.toml", [*changes, *quiet]), below=OWN), []
    for number in (0, OWN, FINEST):
        own = folder / name.replace(" ", "_") / f"level_{number}"
        if not Level.is_done(own):
            ended = simulation.run(levels.coarsened(number), own, restart=True)
            if not ended.done:
                raise SystemExit(f"{name}, level {number} stopped: {ended.reason}")
        found.append(Level.read(number, own, QUANTITIES))
    return found


def main() -> None:
    """Run, and print what is told and what is true."""
    options = argparse.ArgumentParser()
    options.add_argument("--scene", action="append", choices=list(SCENES), help="one of the scenes; all unless given")
    options.add_argument("--out", type=Path, default=Path("results/companion"))
    asked = options.parse_args()
    for name in asked.scene or SCENES:
        companion, own, finest = levels_of(name, asked.out)
        told = Answer(QUANTITIES, 1.0, (companion, own)).estimates
        print(
            f"{name}: the companion takes {companion.cost.seconds / own.cost.seconds:.2f} of the run's time", flush=True
        )
        for quantity, one in told.items():
            true = abs(own.values[quantity] - finest.values[quantity]) / abs(own.values[quantity])
            held = "inside" if true <= one.relative else "outside"
            print(f"  {quantity}: told {100 * one.relative:.2g} %, true {100 * true:.2g} %: {held}", flush=True)


if __name__ == "__main__":
    main()
