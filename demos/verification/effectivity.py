"""The estimated error of the field of Vf over its true one, for elements along the layers and through them.

Run: ``docker/run python3 demos/verification/effectivity.py [FOLDER] [SCENE ...]``

The scenes are those below, as strips in plane strain where nothing varies along y. Layers that bend apart from their
membrane have one element through them by definition: their reference is finer in the plane alone. Prints a line for
each run, and writes all to ``effectivity.csv``. What is in the folder already is not run again.
"""

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx import Scene
from ncf_fenicsx.report.reading import read_history
from ncf_fenicsx.report.reference_solution import VfField
from ncf_fenicsx.workers.launch import BARE, launch

LIMIT = 3600.0
SOFT = "laws.shear.modulus=2 MPa"
STIFF = ("tool.penalty=1e11 Pa/m", "interface.penalty=1e10 Pa/m")


def strip(length: int) -> tuple[str, ...]:
    """A strip 1 mm wide of a scene that is as long (mm)."""
    return ("stack.sides.y_min=symmetry", "stack.sides.y_max=symmetry", f"stack.size=['{length} mm', '1 mm']")


@dataclass(frozen=True)
class Case:
    """A scene, its meshes as elements along x, along y and through each layer, and the finest one.

    Attributes:
        file: of the scene, without its ending.
        overrides: of the scene.
        meshes: that are judged.
        reference: that they are judged by.
    """

    file: str
    overrides: tuple[str, ...]
    meshes: tuple[tuple[int, int, int], ...]
    reference: tuple[int, int, int]


THROUGH = tuple((30, 1, through) for through in (1, 2, 3, 4))


def pressed(depth: float) -> str:
    """A path straight down by a depth (mm)."""
    return f"tool.path=[{{travel=['0 mm', '0 mm', '-{depth} mm'], speed='2 mm/min'}}]"


SET = (
    "laws={shear={modulus='2 MPa'}, relaxation={kind='maxwell', branches=[{share=0.2, time='10 s'}]}, "
    "unloading={kind='permanent_set'}}"
)
CASES = {
    "long roller, 2 MPa": Case("long_roller", (*strip(30), *STIFF, SOFT), THROUGH, (60, 1, 16)),
    "long roller, 10 MPa": Case("long_roller", (*strip(30), *STIFF, "laws.shear.modulus=10 MPa"), THROUGH, (60, 1, 16)),
    "deep, 2 MPa, to 1 mm": Case("deep", (*strip(30), SOFT, pressed(1)), THROUGH, (60, 1, 8)),
    "deep to 1.5 mm": Case("deep", (*strip(30), pressed(1.5)), THROUGH[:3], (45, 1, 8)),
    "press, hold, lift, no bending": Case("relaxation", (*strip(30), SET), THROUGH[:3], (60, 1, 8)),
    "relaxation": Case("relaxation", strip(30), ((22, 1, 1), (45, 1, 1), (90, 1, 1)), (360, 1, 1)),
    "moving roller": Case("moving_roller", strip(60), ((75, 1, 1), (150, 1, 1), (300, 1, 1)), (600, 1, 1)),
    "roller that bends": Case("roller", ("laws.bending.modulus=0.1 GPa",), ((20, 12, 1),), (60, 36, 1)),
}


def solved(case: Case, mesh: tuple[int, int, int], folder: Path) -> Path | None:
    """Folder of a run on a mesh; None if it does not reach its end."""
    x, y, through = mesh
    place = folder / f"{x}_{y}_{through}"
    if not (place / "run.json").exists():
        changes = (*case.overrides, f"stack.divisions=[{x}, {y}]", f"stack.through={through}", *BARE)
        ended = launch(Path(__file__).parents[1] / f"{case.file}.toml", place, changes, LIMIT)
        if ended.ending != "done":
            print(f"{place}: {ended.ending}, {ended.reason}", flush=True)
            return None
    return place


def judged(name: str, folder: Path) -> list[dict[str, str]]:
    """Rows of a case."""
    case, rows = CASES[name], []
    rest = Scene.read(Path(__file__).parents[1] / f"{case.file}.toml", case.overrides).stack.initial_volume_fraction
    reference = solved(case, case.reference, folder)
    for mesh in case.meshes:
        place = solved(case, mesh, folder)
        if place is not None and reference is not None:
            true = VfField(place).off(VfField(reference), rest)
            found = float(read_history(place / "history.csv")["vf_error"][-1])
            rows.append(
                {
                    "scene": name,
                    "mesh": " x ".join(map(str, mesh)),
                    "true": f"{true:.4f}",
                    "estimated": f"{found:.4f}",
                    "effectivity": f"{found / true:.2f}",
                }
            )
            print("  ".join(f"{value:>20}" for value in rows[-1].values()), flush=True)
    return rows


def main(folder: Path, names: list[str]) -> None:
    """Judge cases, all unless some are named."""
    rows = [row for name in names or CASES for row in judged(name, folder / name.replace(" ", "_"))]
    with (folder / "effectivity.csv").open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, ["scene", "mesh", "true", "estimated", "effectivity"])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/effectivity"), sys.argv[2:])
