"""Numbers from the constants of laws, without a mesh."""

from itertools import pairwise

import numpy as np
import ufl

from ncf_fenicsx import Scene
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.kinematics import Kinematics
from ncf_fenicsx.laws.law import CompactionStep, number
from ncf_fenicsx.parameters.kinds import kinds

MM_PER_MIN = 1e-3 / 60
VF0 = Scene.from_table({"duration": "1 s"}).stack.initial_volume_fraction


def numbers(tensor):
    """Values of a UFL tensor without fields."""
    return np.array([number(tensor[index]) for index in np.ndindex(*tensor.ufl_shape)]).reshape(tensor.ufl_shape)


def law(family, kind, **keys):
    """A law from its table."""
    return kinds(family)[kind].model_validate(keys)


def strained(deformation_gradient, measure="thickness"):
    """Kinematics of a constant deformation gradient."""
    return Kinematics(ufl.as_matrix(np.asarray(deformation_gradient).tolist()), ufl.as_ufl(VF0), measure)


def in_step(compaction, vf, old_vf=VF0, time_step=1e30, process_speed=0.0):
    """What a law is told of a step, for ever unless given."""
    return CompactionStep(
        ufl.as_ufl(vf),
        ufl.as_ufl(old_vf),
        VF0,
        time_step,
        1 / time_step,
        process_speed,
        lambda x: compaction.pressure(x, VF0),
    )


def march(laws, compaction, history, rate=None):
    """Pressures of stateful laws over a history of (time, Vf), with the rate factor on the slow one if given.

    Args:
        laws: unloading or relaxation laws, or both.
        compaction: the loading curve.
        history: rows of time in s and Vf, from Vf0 at the start.
        rate: rate law fed by local speed.
    """
    states = {name: value for law in laws for name, value in law.initial_states(VF0).items()}
    pressures = [0.0]
    for (t0, vf0), (t1, vf1) in pairwise(history):
        step = in_step(compaction, vf1, vf0, max(t1 - t0, 1e-12))
        unloading = [law for law in laws if law.family == "unloading"]
        slow = unloading[0].pressure(step, states) if unloading else step.loading(step.volume_fraction)
        slow = slow if rate is None else rate.apply(step, slow)
        extra = sum(law.pressure(step, states) for law in laws if law.family == "relaxation")
        pressures.append(number(slow + extra))
        updated = {name: value for law in laws for name, value in law.updated_states(step, states).items()}
        states = {name: number(value) for name, value in updated.items()}
    return np.array(pressures)


RNG = np.random.default_rng(5)
DEFORMATIONS = [np.eye(3) + RNG.uniform(-0.1, 0.1, (3, 3)) for _ in range(3)]
TURN = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
TURN *= np.sign(np.linalg.det(TURN))

EXPONENTIAL = Exponential()
TWO = law("relaxation", "maxwell", branches=[{"share": 0.3, "time": "1 s"}, {"share": 0.2, "time": "100 s"}])
SET = law("unloading", "permanent_set", set_share=0.6, exponent=4.0)


def loading(vf):
    return EXPONENTIAL.pressure(vf, VF0)


def rows(times, vf):
    return list(zip(np.asarray(times, dtype=float), np.asarray(vf, dtype=float), strict=True))
