"""Automatic meshes against the default mesh and a scene's own one, each refined evenly: error of Vf over cost.

Run: ``docker/run python3 demos/verification/automatic_mesh.py SCENE.toml FOLDER [KEY=VALUE ...]``

The reference is the scene's own mesh with sixteen times as many elements along x and one along y: so nothing may vary
along y. Prints each run's error of the field of Vf in the plane and of the largest force, its unknowns, iterations and
processor time without compiling forms, of coarse run and run together; and writes them to ``automatic_mesh.csv``.
Before them stands the least error that as many elements along x as the scene has can have.
What is in the folder already is not run again.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from ncf_fenicsx import Scene
from ncf_fenicsx.grid_lines import grid_lines
from ncf_fenicsx.mesh.equidistribution import constant_of
from ncf_fenicsx.report.reading import read_history, read_record
from ncf_fenicsx.report.reference_solution import VfField
from ncf_fenicsx.study.machine import machine
from ncf_fenicsx.workers.launch import BARE, folder_name, launch

DEFAULT = {0.25: (30, 6), 0.5: (60, 12), 1: (120, 24)}
"""The default divisions by a factor."""
OWN = (0.5, 1, 2)
ERRORS = (0.02, 0.01, 0.005, 0.003, 0.0015, 0.001)
FINEST = 16
COARSE = "coarse_run"
LIMIT = 3600.0


def meshes(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Overrides of each mesh by its name, the reference first."""
    x, y = scene.stack.divisions_by_layer[0]
    found: dict[str, tuple[str, ...]] = {"reference": (f"stack.divisions=[{FINEST * x}, 1]",)}
    for error in ERRORS:
        found[f"automatic, {100 * error:g} %"] = ("stack.divisions=automatic", f"stack.mesh_error={error}")
    for factor in OWN:
        found[f"own, times {factor:g}"] = (f"stack.divisions=[{round(factor * x)}, {max(round(factor * y), 1)}]",)
    for factor, (along_x, along_y) in DEFAULT.items():
        overrides = (f"stack.divisions=[{along_x}, {along_y}]", "stack.grading=[0.9, 0.8]")
        found[f"default, times {factor:g}"] = overrides
    return found


def cost(folder: Path) -> dict[str, float]:
    """Unknowns and iterations of a run, and processor time in s; all with its coarse run, but for the unknowns."""
    records = [read_record(place) for place in (folder, folder / COARSE) if (place / "run.json").exists()]
    seconds = records[0]["seconds_cpu"] - sum(record["seconds"]["forms"] for record in records)  # of one process
    return {
        "unknowns": records[0]["unknowns"],
        "iterations": sum(record["newton_iterations"] for record in records),
        "processor_s": round(seconds, 2),
    }


def best(reference: VfField, rest: float, count: int) -> float:
    """Least error that a number of elements along x can have, for a field that is known; over the field's change."""
    lines, _ = grid_lines(np.append(reference.low[:, 0], reference.high[:, 0]), reference.extent)
    columns, levels = (grid_lines(reference.low[:, axis], reference.extent)[1] for axis in (0, 2))
    field = reference.values[np.lexsort((columns, levels))].reshape(-1, len(lines) - 1)
    middles = (lines[1:] + lines[:-1]) / 2
    squares = ((np.diff(field, axis=1) / np.diff(middles)) ** 2).sum(axis=0)
    change = np.sqrt(((field - rest) ** 2).sum(axis=0) @ np.diff(lines))
    return float(constant_of(middles, squares) / count / change)


def main(file: Path, folder: Path, overrides: tuple[str, ...]) -> None:
    """Run all that is missing; print and write the table."""
    scene = Scene.read(file, overrides)
    rows = []
    places = {name: folder / folder_name(name) for name in meshes(scene)}
    for name, changes in meshes(scene).items():
        if not (places[name] / "run.json").exists():
            ended = launch(file, places[name], (*overrides, *changes, *BARE), LIMIT)
            print(f"{name}: {ended.ending}, {ended.reason}", flush=True)
    reference, rest = VfField(places.pop("reference")), scene.stack.initial_volume_fraction
    finest = read_history(folder / "reference" / "history.csv")["tool_force"].max()
    for name, place in places.items():
        force = read_history(place / "history.csv")["tool_force"].max()
        errors = {"vf_field": f"{VfField(place).off(reference, rest):.4f}", "force": f"{abs(force / finest - 1):.5f}"}
        estimate = {"vf_error_in_plane": f"{read_history(place / 'history.csv')['vf_error_in_plane'][-1]:.4f}"}
        rows.append({"mesh": name} | errors | estimate | cost(place))
    (x, _), *_ = scene.stack.divisions_by_layer
    print(f"the best {x} elements along x: {best(reference, rest, x):.4f}")
    print(machine())
    for row in rows:
        print("  ".join(f"{value!s:>18}" for value in row.values()))
    with (folder / "automatic_mesh.csv").open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), tuple(sys.argv[3:]))
