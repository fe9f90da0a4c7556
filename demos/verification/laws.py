"""Every law and cycle in one figure: dots are what the program computes, lines closed forms and sources.

Run: ``docker/run python3 demos/laws.py [RESULTS_FOLDER]`` or with ``mpirun -n 2`` before ``python3``.
"""

import sys
from pathlib import Path

import laws_evaluated as evaluated
import laws_pressed as pressed
from laws_compared import Worst
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpi4py import MPI


def main(folder: Path) -> Worst:
    """Run the elements, draw the figure, return the differences."""
    worst, figure = Worst(), Figure(figsize=(17, 15), layout="constrained")
    axes = figure.subplots(4, 3).ravel()
    pressed.draw_compaction(axes[0], folder, worst)
    evaluated.draw_toe(axes[1])
    evaluated.draw_rate(axes[2])
    pressed.draw_relaxation(axes[3], folder, worst)
    pressed.draw_unloading(axes[4], folder, worst)
    pressed.draw_cycle(axes[5], folder)
    evaluated.draw_fibres(axes[6], worst)
    evaluated.draw_printed(axes[7], worst)
    evaluated.draw_shear(axes[8], worst)
    evaluated.draw_permeability(axes[9])
    pressed.draw_solids(axes[10], folder, worst)
    evaluated.draw_bending(axes[11], worst)
    for panel in axes:
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small")
    if MPI.COMM_WORLD.rank == 0:
        FigureCanvasAgg(figure).print_png(folder / "laws.png")
        print(*(f"{name}: {value:.1e} from its closed form" for name, value in worst.of.items()), sep="\n")
    return worst


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "results/laws")
    if max(main(target).of.values()) > 1e-6:
        sys.exit("a law differs from its closed form")
