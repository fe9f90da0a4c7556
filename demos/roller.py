"""The roller scene from Python: ``mpirun -n 2 python3 demos/roller.py [RESULTS_FOLDER] [KEY=VALUE ...]``."""

import sys
from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx import Scene, run


def main(folder: Path, overrides: list[str]) -> bool:
    """Run the scene and say how it ended; whether the end of the path was reached."""
    scene = Scene.read(Path(__file__).with_name("roller.toml"), overrides)
    result = run(scene, folder, overwrite=True)
    if MPI.COMM_WORLD.rank == 0:
        last = result.history[-1]
        print(f"{result.reason}: force {last['tool_force']:.4g} N, largest Vf {last['vf_max']:.4f}, see {folder}")
    return result.done


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/roller_from_python")
    sys.exit(not main(folder, sys.argv[2:]))
