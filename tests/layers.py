"""Layers on layers: runs with their problem at hand, and two layers that are moved as told."""

import numpy as np
from assembled import COMM

from ncf_fenicsx import Scene
from ncf_fenicsx.simulation import Simulation

QUIET = {"picture": False, "report": False}
ELASTIC = {"rate": {"kind": "none"}}


def simulate(table, folder):
    """A run to its end, with its problem at hand."""
    simulation = Simulation(Scene.from_table(table | {"output": QUIET}), folder, COMM, overwrite=False)
    result = simulation.run()
    assert result.done, result.reason
    return simulation, result.history


def everywhere(values):
    return np.concatenate(COMM.allgather(np.asarray(values)))


PENALTY, PRESSED = 1e9, 1e-6
PARTS = {"matching": [6, 2], "different": [[6, 2], [5, 3]], "finer above": [[6, 2], [11, 5]]}


def two_layers(divisions, **interface):
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": divisions, "grading": [0, 0]},
        "interface": {"penalty": f"{PENALTY} Pa/m"} | interface,
        "duration": "1 s",
    }


def upper_nodes(problem):
    """Which local nodes belong to the upper of two layers, and which of them lie on the lower."""
    pairing = problem.contacts.layers[0].pairing
    facing = np.isin(problem.contacts.body.spaces.numbers, pairing.masters)
    return facing | (problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3), facing


def move(problem, upper, along=0.0, across=0.0, lift=0.0):
    problem.displacement.x.array.reshape(-1, 3)[upper] = (along, across, lift)


STITCH = {"kind": "stitched", "yarn_stiffness": "8 N", "yarn_length": "2 mm", "pitch": ["4 mm", "10 mm"]}
