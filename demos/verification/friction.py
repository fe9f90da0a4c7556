"""How Newton's method takes friction: iterations and cuts over its coefficient and stick stiffness.

Run: ``docker/run python3 demos/verification/friction.py [KEY=VALUE ...]``; prints a table, in some six minutes. The
scene is ``demos/wrinkle.toml`` on elements of 1 mm; coefficients and factors are those of the foot, the mould and the
interface alike.
"""

import json
import sys
import tempfile
from pathlib import Path

from ncf_fenicsx import Scene, run

SCENE = Path(__file__).parents[1] / "wrinkle.toml"
COEFFICIENTS = (0.05, 0.2, 0.5, 1.0, 2.0)
FACTORS = (0.01, 0.1, 1.0, 10.0, 100.0)
COARSE = ["stack.divisions=[80, 1]", "output.fields_every=1000", "output.picture=false", "output.report=false"]


def pushed(coefficient: float, factor: float, more: list[str]) -> str:
    """Iterations, cuts and the height of the wrinkle in mm; or the time in s at which the run stopped."""
    friction = [
        f"{surface}.friction.{key}={value}"
        for surface in ("tool", "mould", "interface")
        for key, value in (("coefficient", coefficient), ("stiffness", factor))
    ]
    scene = Scene.read(SCENE, COARSE + friction + more)
    with tempfile.TemporaryDirectory() as folder:
        result = run(scene, folder, overwrite=True)
        record = json.loads((Path(folder) / "run.json").read_text())
    height = 1e3 * result.history[-1]["mould_wrinkle_height"]
    cost = f"{record['newton_iterations']} iterations, {record['step_cuts']} cuts"
    return f"{cost}, {height:.2f} mm" if result.done else f"{cost}, stopped at {result.history[-1]['time']:.2f} s"


if __name__ == "__main__":
    for coefficient in COEFFICIENTS:
        for factor in FACTORS:
            print(f"mu {coefficient}, factor {factor}: {pushed(coefficient, factor, sys.argv[1:])}", flush=True)
