"""The page of made-up results as large as asked for: python3 tests/large_page.py RUN FOLDER 165 164 30.

RUN is a folder of results of four layers. FOLDER gets its scene and history, and field files with as many elements
along x and y and as many steps, with noise of 2 % on each value, which no packing makes small.
"""

import resource
import shutil
import sys
import time
from pathlib import Path

import meshio
import numpy as np

from ncf_fenicsx.report.page import write_report
from ncf_fenicsx.report.reading import Results

MM = 1e-3
PRESSED = {"contact_pressure": 1e5, "gap": 1e-5, "slip": 1e-6}
PVD = '<VTKFile type="Collection"><Collection>{}</Collection></VTKFile>'


def stack(along, across, layers):
    """Points in m, hexahedra and the layer of each, in a quarter of 152 x 152 mm in layers of 2 mm."""
    x, y = (np.linspace(0, 76 * MM, count + 1) for count in (along, across))
    points, cells = [], []
    for number in range(layers):
        grid = np.stack(np.meshgrid(x, y, 2 * MM * np.array([number, number + 1]), indexing="ij"), -1)
        node = len(points) * grid[..., 0].size + np.arange(grid[..., 0].size).reshape(grid.shape[:3])
        low, high = slice(None, -1), slice(1, None)
        plan = ((low, low), (high, low), (high, high), (low, high))
        cells.append(np.stack([node[a, b, level] for level in (0, 1) for a, b in plan], -1).reshape(-1, 8))
        points.append(grid.reshape(-1, 3))
    return np.concatenate(points), np.concatenate(cells), np.repeat(np.arange(layers) + 1.0, len(cells[0]))


def write_fields(run, folder, along, across, steps):
    """Results with made-up fields, of the scene and with the history of a run."""
    results = Results.read(run)
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "fields").mkdir(parents=True)
    for name in ("scene.toml", "history.csv", "run.json"):
        shutil.copy(run / name, folder / name)
    points, cells, layer = stack(along, across, results.scene.stack.layers)
    random, entries = np.random.default_rng(0), []

    def noisy(values):
        return values * (1 + 0.02 * random.standard_normal(values.shape))

    for number, when in enumerate(np.linspace(0, results.history["time"][-1], steps)):
        done = number / max(steps - 1, 1)
        at_nodes, in_cells = (
            done * np.exp(-((p[:, 0] / (20 * MM)) ** 2) - (p[:, 1] / (30 * MM)) ** 2)
            for p in (points, points[cells].mean(axis=1))
        )
        moved = noisy(at_nodes[:, None] * [0.01 * MM, 0.01 * MM, -0.5 * MM])
        nodes = {"displacement": moved} | {name: noisy(size * at_nodes) for name, size in PRESSED.items()}
        own = {
            "layer": [layer],
            "volume_fraction": [0.4 + noisy(0.08 * in_cells)],
            "stress_33": [-noisy(3e3 * in_cells)],
        }
        meshio.Mesh(points, [("hexahedron", cells)], point_data=nodes, cell_data=own).write(
            folder / "fields" / f"{number:04d}.vtu", compression=None
        )
        entries.append(f'<DataSet timestep="{when}" file="fields/{number:04d}.vtu"/>')
    (folder / "fields.pvd").write_text(PVD.format("".join(entries)), encoding="utf-8")


def main():
    run, folder, along, across, steps = Path(sys.argv[1]), Path(sys.argv[2]), *map(int, sys.argv[3:])
    write_fields(run, folder, along, across, steps)
    start = time.monotonic()
    page = write_report(folder)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{page}: {page.stat().st_size / 1e6:.1f} MB, {time.monotonic() - start:.1f} s, {memory:.0f} MB of memory")


if __name__ == "__main__":
    main()
