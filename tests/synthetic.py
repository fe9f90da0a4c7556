"""Compaction tests made from known laws: a press at a speed, with noise of a given share on the force."""

import numpy as np

from ncf_fenicsx.calibration.histories import History
from ncf_fenicsx.calibration.specimens import Compaction, Machine
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.rate import KellyRate

PAPER = {"compaction": Exponential(), "rate": KellyRate()}
AREA, AREAL, DENSITY = 0.152**2, 1.425, 1790.0
NOISE = 0.03
ROWS = 60


def moved(laws, time, thickness, millimetres, rng=None, machine=Machine()):  # noqa: B008
    """A test whose thickness follows a path; the machine's own travel is added to it."""
    layers = round(millimetres / 2)
    fibres = layers * AREAL / DENSITY

    def test(apparent, force):
        return Compaction(
            f"{millimetres} mm", time, apparent, force, AREA, millimetres * 1e-3, layers, fibres, AREAL, DENSITY
        )

    true = test(np.asarray(thickness), np.zeros(len(time)))
    force = History(laws, true, Machine()).pressure * AREA
    if rng is not None:
        force = force * (1 + NOISE * rng.standard_normal(len(force)))
    return test(thickness - machine.compliance * force - machine.slack, force)


def press(laws, times, millimetres, speed, rng=None, machine=Machine()):  # noqa: B008
    """A press from Vf0 to Vf 0.60 at a speed in mm/min."""
    start, fibres = millimetres * 1e-3, millimetres / 2 * AREAL / DENSITY
    end = fibres / 0.60
    duration = (start - end) / (speed * 1e-3 / 60)
    time = np.linspace(0, times * duration, ROWS)
    return moved(laws, time, start - speed * 1e-3 / 60 * time, millimetres, rng, machine)


def specimens(rng, laws=PAPER):
    """Five specimens: 4 mm at 1, 2 and 5 mm/min, 8 mm at 1 and 5 mm/min."""
    return [press(laws, 1, thickness, speed, rng) for thickness, speed in ((4, 1), (4, 2), (4, 5), (8, 1), (8, 5))]
