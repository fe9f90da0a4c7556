"""Multipliers of contact: what updates leave of a penetration, and the penalty that they raise where they are slow."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from assembled import COMM, assign, build, bumpy
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.contact.multiplier import RAISE, SLOW, Multiplier
from ncf_fenicsx.laws.contact import AugmentedLagrangian, most_raised
from ncf_fenicsx.mechanics.time_step import TimeStep
from ncf_fenicsx.simulation.step import AugmentedNewton

pytestmark = pytest.mark.two_ranks

BLOCK = {
    "gravity": "0 m/s^2",
    "laws": {"solid": {"modulus": "1 MPa", "poisson": 0.0}},
    "stack": {"layers": 1, "thickness": "4 mm", "size": ["6 mm", "6 mm"], "divisions": [2, 2]},
    "output": {"picture": False, "report": False},
}
MODULUS, HEIGHT = 1e6, 4e-3
PUSHED = 1e-5


def pressed(penalty, tolerance=1e-6):
    """A block under a plate that goes down by 10 um in one step: the exact pressure is that of a column."""
    tool = {
        "kind": "plate",
        "penalty": penalty,
        "contact": {"kind": "augmented_lagrangian", "tolerance": tolerance},
        "path": [{"travel": ["0 mm", "0 mm", f"-{1e3 * PUSHED:g} mm"], "speed": "1 mm/min"}],
    }
    return BLOCK | {"tool": tool, "solver": {"first_step": "0.6 s", "largest_step": "0.6 s", "force_tolerance": 1e-8}}


def penetrations(problem, monkeypatch):
    """Deepest penetrations (m) that each update of a step starts from."""
    seen, multiplier = [], problem.contacts.tools[0].multiplier
    update = multiplier.update

    def seen_update(deepest):
        seen.append(deepest)
        return update(deepest)

    monkeypatch.setattr(multiplier, "update", seen_update)
    return seen


def test_updates_leave_the_share_of_a_penetration_that_the_penalty_gives(monkeypatch):
    """A column of stiffness E / h under a penalty of k: each update leaves E / (E + k h)."""
    stiffness = 2e9
    problem, newton = build(pressed(f"{stiffness:g} Pa/m"))
    seen = penetrations(problem, monkeypatch)
    assert TimeStep(problem, AugmentedNewton(problem, newton).solve).attempt(0.0, 0.6).converged
    left = 1 / (1 + stiffness * HEIGHT / MODULUS)
    assert left < SLOW
    ratios = np.divide(seen[1:], seen[:-1])
    assert len(ratios) > 1
    assert ratios == pytest.approx(left, rel=0.02)
    assert problem.contacts.tools[0].multiplier.state[1].values == 1


def test_a_penalty_too_soft_for_its_updates_is_raised_until_they_are_fast(monkeypatch):
    soft = 1e7
    problem, newton = build(pressed(f"{soft:g} Pa/m"))
    seen = penetrations(problem, monkeypatch)
    time_step = TimeStep(problem, AugmentedNewton(problem, newton).solve)
    assert time_step.attempt(0.0, 0.6).converged
    ratios = np.divide(seen[1:], seen[:-1])
    assert ratios[0] == pytest.approx(1 / (1 + soft * HEIGHT / MODULUS), rel=0.02)
    assert ratios[-1] < SLOW
    assert len(seen) < 10, "without a raise it takes 200 updates"
    factor = problem.contacts.tools[0].multiplier.state[1]
    assert factor.values[0] > 1
    assert math.log(factor.values[0], RAISE) == pytest.approx(round(math.log(factor.values[0], RAISE)))
    time_step.rollback(0.0)
    assert factor.values == 1


def test_a_penalty_is_raised_where_its_own_updates_are_slow_and_no_further_than_it_may_be(table):
    """In tolerances: what grows again after it was within them grows for another contact's updates."""
    body = build(table)[0].contacts.body
    unit = 1e-4 * body.thickness
    multiplier = Multiplier("any", AugmentedLagrangian(), body, most=50.0)
    multiplier.state = [SimpleNamespace(advance=lambda: None)]
    raised = []
    for deepest in (10, 0.9, 3, 2, 1.9, 0.4, 1.5, 1.4):
        multiplier.update(deepest * unit)
        raised.append(float(multiplier._factor.value[0]))
    assert raised == [1, 1, 1, 10, 50, 50, 50, 50]
    multiplier.begin()
    assert multiplier._deepest == math.inf
    assert most_raised(160.0, 1e9, 1e8) == 16
    assert most_raised(160.0, 1e11, 1e8) == 1


def test_a_raised_penalty_presses_at_tools_and_between_layers(table):
    """With no multiplier yet, the pressure of a penetration is in proportion to the penalty."""
    way = {"contact": {"kind": "augmented_lagrangian"}}
    problem, _ = build(table | {"tool": table["tool"] | way, "interface": {"kind": "one_sided"} | way})
    assign(problem, bumpy)
    problem.contacts.tools[0].tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    problem.contacts.refresh()
    for contact in (problem.contacts.tools[0], problem.contacts.layers[0]):
        before = contact.face.values(contact.pressure_form)
        assert COMM.allreduce(before.max(initial=0.0), MPI.MAX) > 0
        contact.multiplier.state[1].values[:] = RAISE
        assert contact.face.values(contact.pressure_form) == pytest.approx(RAISE * before, rel=1e-12)


@pytest.mark.serial
def test_the_pressure_is_that_of_the_column_whatever_the_penalty(folder):
    for number, penalty in enumerate(("1e7 Pa/m", "1e9 Pa/m", "1e11 Pa/m")):
        result = run(Scene.from_table(pressed(penalty)), folder / str(number))
        assert result.done, result.reason
        assert result.history[-1]["pressure_max"] == pytest.approx(MODULUS * PUSHED / HEIGHT, rel=5e-3)
        assert result.history[-1]["penetration_max"] < 1e-6 * HEIGHT
