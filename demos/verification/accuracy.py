"""Error bars against true errors: where sequences of runs stop at 5, 2 and 1 %, and whether what they state holds.

Run: ``docker/run python3 demos/verification/accuracy.py [--scene NAME ...] [--levels NUMBER] [--out FOLDER]``

The levels of each scene are run once. A sequence that asks for a tolerance stops at one of them; what it would state
there is held against a reference from two more levels: their extrapolated limit, or the finest value where no order
settles. It goes on where it was ended, and weighs the levels that are there.
"""

import argparse
import csv
import math
import statistics
import sys
from dataclasses import replace
from pathlib import Path

from ncf_fenicsx import Scene, simulation
from ncf_fenicsx.accuracy.answer import Answer, Level
from ncf_fenicsx.accuracy.levels import BELOW, Levels, learn
from ncf_fenicsx.accuracy.sequence import FEWEST
from ncf_fenicsx.report.reference_solution import VfField

DEMOS = Path(__file__).parents[1]
TOLERANCES = (0.05, 0.02, 0.01)
FABRIC = ("force", "vf", "vf_field", "void_volume")
FINER = 2
"""Levels by which a reference is finer than what it judges."""
BLOCK = [
    "stack={layers=1, thickness='8 mm', size=['20 mm', '10 mm'], divisions=[40, 1], through=8, grading=[0.7, 0]}",
    "stack.sides={y_max='symmetry'}",
    "laws={solid={kind='logarithmic', modulus='1 MPa', poisson=0.3}}",
    "gravity='0 m/s^2'",
    "tool.radius='10 mm'",
]
SCENES = {
    "long_roller": ("long_roller", ["laws.shear.modulus=2 MPa"], FABRIC),
    "deep": ("deep", [], FABRIC),
    "deep, stable": ("deep", ["laws.shear.modulus=2 MPa"], FABRIC),
    "relaxation": ("relaxation", ["solver.max_iterations=30"], FABRIC),
    "moving_roller": ("moving_roller", ["solver.max_iterations=30"], FABRIC),
    "elastic block": ("deep", BLOCK, ("force",)),
    "roller": ("roller", ["laws.bending.modulus=0.1 GPa"], FABRIC),
}
"""File, changes and quantities by name. Fine levels of deep lose their stability, in shear of 2 MPa they do not."""
COLUMNS = ("scene", "quantity", "asked", "level", "seconds", "value", "bar", "true_error", "inside", "bar_over_error")


def answers(name: str, most: int, folder: Path) -> list[Answer]:
    """What each level of a scene tells, run where it is not done yet; up to one that stops."""
    file, changes, quantities = SCENES[name]
    quiet = ["output.picture=false", "output.report=false", "output.fields_every=1000000"]
    scene = Scene.read(DEMOS / f"{file}.toml", [*changes, *quiet])
    levels, answer, found = Levels(scene), Answer(quantities, min(TOLERANCES)), []
    for number in range(most):
        own = folder / name.replace(" ", "_") / f"level_{number}"
        if not Level.is_done(own):
            print(f"{name}, level {number}: {levels.words(number)}", flush=True)
            ended = simulation.run(Scene.from_table(levels[number].table()), own, restart=True)
            if not ended.done:
                print(f"{name}, level {number} stopped: {ended.reason}", flush=True)
                if number >= BELOW:
                    break
                answer, found = replace(answer, levels=(), changes=()), []  # as a sequence does
                continue
        answer = answer.with_level(number, own, scene)
        found.append(answer)
        if len(found) == 1:
            levels = Levels(scene, learn(scene, own))
    return found


def weighed(name: str, found: list[Answer]) -> list[dict[str, str]]:
    """A row for each quantity and tolerance that was reached two levels or more before the last."""
    rows = []
    for quantity in SCENES[name][2]:
        for asked in TOLERANCES:
            reached = [number for number, one in enumerate(found) if one.estimates[quantity].relative <= asked]
            stop = next((number for number in reached if number >= FEWEST - 1), None)
            if stop is None or stop + FINER >= len(found):
                continue
            one, seconds = found[stop].estimates[quantity], sum(level.wall for level in found[stop].levels)
            off = true_error(quantity, found, stop)
            numbers = (one.value, one.relative, off / abs(one.value))
            row = (name, quantity, f"{100 * asked:g} %", str(stop), f"{seconds:.1f}", *(f"{n:.4g}" for n in numbers))
            ratio = f"{one.bar / off:.2f}" if off else "infinite"
            rows.append(dict(zip(COLUMNS, (*row, str(off <= one.bar), ratio), strict=True)))
    return rows


def true_error(quantity: str, found: list[Answer], stop: int) -> float:
    """Of a level, against what the finest ones tell."""
    if quantity == "vf_field":
        fields = [VfField(level.folder) for level in found[-1].levels]
        rest = Scene.read(found[-1].levels[-1].folder / "scene.toml").stack.initial_volume_fraction
        return fields[stop].off(fields[-1], rest) * fields[-1].change(rest)
    last = found[-1].estimates[quantity]
    reference = last.value if math.isnan(last.limit) else last.limit
    return abs(found[stop].estimates[quantity].value - reference)


def main() -> None:
    """Run, weigh, write ``accuracy.csv``, and say how many bars hold."""
    options = argparse.ArgumentParser()
    options.add_argument("--scene", action="append", choices=list(SCENES), help="one of the scenes; all unless given")
    options.add_argument("--levels", type=int, default=5, help="of each scene, three at least")
    options.add_argument("--out", type=Path, default=Path("results/accuracy"))
    asked = options.parse_args()
    rows = []
    for name in asked.scene or SCENES:
        rows += weighed(name, answers(name, asked.levels, asked.out))
    asked.out.mkdir(parents=True, exist_ok=True)
    with (asked.out / "accuracy.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    inside = sum(row["inside"] == "True" for row in rows)
    if not rows:
        sys.exit(f"no tolerance was reached {FINER} levels before the last: expected more --levels")
    over = statistics.median(float(row["bar_over_error"]) for row in rows)
    print(f"{inside} of {len(rows)} true errors are inside their bars; the median bar is {over:.3g} true errors")


if __name__ == "__main__":
    main()
