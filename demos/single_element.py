"""One hexahedron pressed at 1, 2 and 5 mm/min, over the closed form of the compaction law (paper, Fig. 5).

Run: ``docker/run python3 demos/single_element.py [RESULTS_FOLDER]``
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpi4py import MPI

from ncf_fenicsx import Scene, run

SPEEDS = (1, 2, 5)
HERE = Path(__file__).parent
KPA = 1e-3


def closed_form(scene: Scene, volume_fraction: np.ndarray) -> np.ndarray:
    """Pressure of the law in Pa at the scene's speed."""
    law, rate = scene.laws.compaction, scene.laws.rate
    return rate.factor(scene.segments[0].speed) * law.pressure(volume_fraction, scene.stack.initial_volume_fraction)


def main(folder: Path) -> float:
    """Run the three speeds; return the largest relative difference from the closed form."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.add_subplot(xlabel="fibre volume fraction", ylabel="pressure (kPa)")
    axes.set_title("One hexahedron under a flat plate")
    worst, lines = 0.0, []
    for speed in SPEEDS:
        scene = Scene.read(HERE / "single_element.toml", [f"tool.path.0.speed={speed} mm/min"])
        result = run(scene, folder / f"{speed}_mm_min", overwrite=True)
        assert result.done, result.reason
        area = scene.stack.size[0] * scene.stack.size[1] * scene.stack.sides.copies
        vf = np.array([row["vf_max"] for row in result.history[1:]])
        pressure = np.array([row["tool_force"] for row in result.history[1:]]) / area
        worst = max(worst, float(np.abs(pressure / closed_form(scene, vf) - 1).max()))
        curve = np.linspace(scene.stack.initial_volume_fraction, vf[-1], 200)
        (line,) = axes.plot(curve, KPA * closed_form(scene, curve), label=f"{speed} mm/min, closed form")
        axes.plot(vf, KPA * pressure, "o", color=line.get_color(), markersize=4, label=f"{speed} mm/min, computed")
        at_60 = KPA * float(closed_form(scene, np.array(0.60)))
        as_printed = KPA * float(
            scene.laws.rate.factor(scene.segments[0].speed) * scene.laws.compaction.as_printed(0.60)
        )
        lines.append(f"{speed} mm/min: {at_60:.2f} kPa at Vf 0.60, of which {as_printed:.2f} before the shift")
    if MPI.COMM_WORLD.rank == 0:
        axes.legend()
        axes.grid(alpha=0.3)
        FigureCanvasAgg(figure).print_png(folder / "single_element.png")
        print(*lines, f"largest relative difference from the closed form: {worst:.1e}", sep="\n")
    return worst


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "results/single_element")
    if main(target) > 1e-8:
        sys.exit("the computed pressure differs from the closed form")
