"""Runs in processes of their own, and whether two histories agree."""

import csv
import subprocess
import sys

import numpy as np
from program import DEMOS, ENVIRONMENT

COST = {"wall_time"}
ROUND_OFF = 1e-14
"""Of differences of positions in m, whose displacements are tenths of a mm: the amplitude of a flat face is 1e-15."""


AMPLIFIED = {"vf_error": 100}
"""Columns in which round-off stands larger: the error's share of a change of Vf that is next to nothing at rest. With
two ranks on a loaded machine, whose messages come in another order each time, it repeats to 2e-10, vf_max to 8e-14."""


def compare(history, expected, tolerance=1e-10):
    """Histories agree to a tolerance of each column's largest value."""
    assert len(history) == len(expected)
    for name in set(expected[0]) - COST:
        one, two = (np.array([row[name] for row in rows]) for rows in (history, expected))
        allowed = tolerance * AMPLIFIED.get(name, 1)
        assert np.abs(one - two).max() <= allowed * np.abs(two).max() + ROUND_OFF, name


SLOW_ROLLER = [
    DEMOS / "long_roller.toml",
    *("--set", "stack.divisions=[12, 2]"),
    *("--set", "solver.largest_step=0.2 s", "--set", "solver.first_step=0.2 s"),
    *("--set", "output.picture=false", "--set", "output.report=false", "--set", "output.checkpoint_every=1"),
]


def start(*arguments, ranks=1, code="from ncf_fenicsx.cli import main; main()"):
    """A run in a process of its own, its output in a pipe, in a process group that signals go to."""
    command = [sys.executable, "-c", code, "run", *map(str, arguments)]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    return subprocess.Popen(
        command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def history(folder):
    with (folder / "history.csv").open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
