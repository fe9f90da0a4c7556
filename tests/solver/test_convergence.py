"""What Newton's iterations are taken for: contact that goes back and forth, increments that grow, too many."""

import numpy as np
import pytest
from assembled import COMM, build, step_of

from ncf_fenicsx.mechanics.time_step import Effort
from ncf_fenicsx.solver.convergence import RUNAWAY, RUNAWAY_FROM, Convergence

pytestmark = pytest.mark.two_ranks


class Contact:
    """Says what a test tells it to."""

    controls, holding, holding_layers = (), False, False

    def __init__(self, patterns):
        self.patterns = iter(patterns)

    def touching(self):
        return np.array(next(self.patterns), dtype=bool)


class System:
    """A problem with another contact."""

    def __init__(self, problem, patterns):
        self.displacement, self.scales = problem.displacement, problem.scales
        self.contacts = Contact(patterns)


OPEN, HALF, CLOSED = [0, 0, 0], [0, 1, 0], [1, 1, 1]


@pytest.mark.parametrize(
    ("patterns", "sizes", "cycling"),
    [
        ([OPEN, CLOSED, OPEN, CLOSED], [1, 1, 1], True),
        ([OPEN, CLOSED, OPEN, CLOSED], [1, 0.5, 0.2], False),
        ([OPEN, HALF, CLOSED, OPEN], [1, 1, 1], False),
        ([OPEN, OPEN, OPEN, OPEN], [1, 1, 1], False),
    ],
    ids=["back and forth", "back and forth, dying out", "around", "at rest"],
)
def test_contact_that_goes_back_and_forth_is_a_cycle(table, patterns, sizes, cycling):
    problem, _ = build(table)
    progress = Convergence(System(problem, patterns), problem.scene.solver)
    update = np.zeros(3 * problem.space.dofmap.index_map.size_local)
    for iteration, size in enumerate(sizes, 1):
        update[:] = 1e-6 * size
        progress.follow(iteration, 1.0, 1.0, update)
    assert progress.cycling == cycling
    assert not progress.given_up


def test_a_cycle_that_lasts_is_named_with_its_place(table):
    problem, _ = build(table)
    most = problem.scene.solver.max_iterations
    progress = Convergence(System(problem, [OPEN, CLOSED] * most), problem.scene.solver)
    points = problem.space.tabulate_dof_coordinates()[: problem.space.dofmap.index_map.size_local]
    update = np.full((len(points), 3), 1e-7)
    update[np.all(np.isclose(points, [6e-3, 3e-3, 4e-3]), axis=1), 2] = -1e-6
    for iteration in range(1, most + 1):
        assert not progress.given_up
        progress.follow(iteration, 1.0, 1.0, update.ravel())
    assert progress.given_up == "contact opens and closes in turns, most at (6, 3, 4) mm"


@pytest.mark.parametrize(
    ("search", "ratio", "patience", "given_up"),
    [("work", 0.5, 1.0, 0), ("work", 0.9, 1.0, 1), ("full", 0.5, 1.0, 1), ("work", 0.5, 0.6, 1)],
)
def test_shortened_corrections_that_converge_at_last_may_go_on(table, search, ratio, patience, given_up):
    problem, _ = build(table | {"solver": {"line_search": search}})
    most = round(patience * problem.scene.solver.max_iterations)
    progress = Convergence(System(problem, [OPEN] * 99), problem.scene.solver)
    progress.begin(Effort(patience))
    update = np.full(3 * problem.space.dofmap.index_map.size_local, 1e-6)
    for iteration in range(1, most + 1):
        progress.follow(iteration, 1.0, 1.0, ratio**iteration * update)
    assert bool(progress.given_up) == given_up
    for iteration in range(most + 1, 2 * most + 1):
        progress.follow(iteration, 1.0, 1.0, ratio**iteration * update)
    assert "did not converge" in progress.given_up


def test_increments_that_grow_are_given_up_at_once(table):
    problem, _ = build(table)
    progress = Convergence(System(problem, [OPEN] * 9), problem.scene.solver)
    update = np.full(3 * problem.space.dofmap.index_map.size_local, 0.1 * problem.scales.length)
    progress.follow(1, 1.0, 1.0, update)
    progress.follow(2, 1.0, 1.0, 0.99 * RUNAWAY * update)
    assert not progress.given_up
    progress.follow(3, 1.0, 1.0, 1.01 * RUNAWAY * update)
    assert "grow" in progress.given_up


SMALL = 0.1 * RUNAWAY_FROM


@pytest.mark.parametrize(
    ("sizes", "effort", "given_up_at"),
    [
        ([1, 0.5, 0.9, 0.6, 1.2, 0.7], Effort(may_wander=False), 6),
        ([1, 0.5, 0.9, 0.6, 1.2, 0.7, 0.9, 0.6], Effort(), None),
        ([1, 0.5, 0.9, 0.6, 1.2, 0.4, 0.1], Effort(may_wander=False), None),
        ([40, 30, 35, 31, 60, 32, 33], Effort(may_wander=False), None),
        ([40, 30, 35, 31, 60, 32], Effort(may_wander=False, must_shrink=True), 6),
        ([1, 0.5, 0.6], Effort(may_wander=False, must_shrink=True), 3),
        ([1, 0.5, 0.6, 0.3], Effort(may_wander=False), None),
        ([1, 1e-3, 0.3, 0.1, 0.03, 0.01], Effort(may_wander=False), None),
        ([1, 1e-4, 1.1e-4], Effort(may_wander=False, must_shrink=True), None),
    ],
    ids=[
        *("wander", "may wander", "shrink at last", "large", "large, after trouble", "one that grows", "may grow once"),
        *("fall after a tiny one", "round-off"),
    ],
)
def test_small_corrections_that_do_not_get_smaller_are_given_up_where_they_must(table, sizes, effort, given_up_at):
    problem, _ = build(table)
    progress = Convergence(System(problem, [OPEN] * 99), problem.scene.solver)
    progress.begin(effort)
    update = np.full(3 * problem.space.dofmap.index_map.size_local, SMALL * problem.scales.length)
    for iteration, size in enumerate(sizes, 1):
        progress.follow(iteration, 1.0, 1.0, size * update)
        assert (bool(progress.given_up), progress.wandered) == (iteration == given_up_at,) * 2
    progress.begin(Effort())
    assert not progress.wandered


def test_a_correction_that_changes_contact_may_grow_even_where_others_must_shrink(table):
    problem, _ = build(table)
    progress = Convergence(System(problem, [OPEN, OPEN, OPEN, OPEN, HALF, HALF, HALF]), problem.scene.solver)
    progress.begin(Effort(may_wander=False, must_shrink=True))
    update = np.full(3 * problem.space.dofmap.index_map.size_local, SMALL * problem.scales.length)
    for iteration, size in enumerate([1, 0.5, 0.6, 0.7], 1):
        progress.follow(iteration, 1.0, 1.0, size * update)
    assert not progress.given_up, "the fourth is the first one with the new contact"
    progress.follow(5, 1.0, 1.0, 0.8 * update)
    assert progress.wandered


@pytest.mark.parametrize(("first", "wanders"), [(OPEN, True), (HALF, False)], ids=["it has not changed", "it has"])
def test_the_first_correction_is_one_in_the_same_contact_unless_that_has_changed(table, first, wanders):
    """The first one is made in the contact of the step before, which is held."""
    problem, _ = build(table)
    progress = Convergence(System(problem, [OPEN, OPEN, first, first]), problem.scene.solver)
    progress.begin(Effort(may_wander=False, must_shrink=True))
    update = np.full(3 * problem.space.dofmap.index_map.size_local, SMALL * problem.scales.length)
    for iteration, (size, holding) in enumerate([(1, True), (1.1, False)], 1):
        progress.system.contacts.holding = holding
        progress.follow(iteration, 1.0, 1.0, size * update)
    assert progress.wandered == wanders


def test_a_step_says_that_it_failed_because_its_corrections_wandered(table, monkeypatch):
    problem, newton = build(table)
    time_step = step_of(problem, newton)
    monkeypatch.setattr(Convergence, "_wanders", property(lambda self: len(self._increments) > 2))
    outcome = time_step.attempt(0.0, 1.0)
    assert (outcome.converged, outcome.wandered, outcome.iterations) == (False, True, 2)
    assert "do not get smaller" in outcome.reason


@pytest.mark.parametrize("polishes", [False, True])
def test_a_state_that_balances_is_corrected_once_more_only_where_asked(table, polishes):
    problem, newton = build(table | {"solver": {"force_tolerance": 1e-2, "increment_tolerance": 0.9}})
    time_step = step_of(problem, newton)
    left = []
    for one in (Effort(), Effort(polishes=polishes)):
        assert time_step.attempt(0.0, 0.0).converged
        time_step.commit()
        outcome = time_step.attempt(0.0, 1.0, one)
        assert outcome.converged
        left.append((outcome.iterations, newton.convergence.polished, newton.snes.getFunctionNorm()))
        time_step.rollback(0.0)
    (usual, none, rough), (iterations, polished, fine) = left
    assert (iterations, none, polished) == (usual, 0, int(polishes))
    assert (fine < 1e-2 * rough) == polishes


def test_what_a_polish_unbalances_is_balanced_again(table):
    problem, _ = build(table)
    progress = Convergence(System(problem, [OPEN] * 9), problem.scene.solver)
    progress.begin(Effort(polishes=True))
    update = np.full(3 * problem.space.dofmap.index_map.size_local, 1e-12)
    ends = []
    for iteration, residual in enumerate((1.0, 0.0, 1.0, 0.0, 0.0), 1):
        progress.follow(iteration, residual, 1.0, update)
        ends.append(progress.converged)
    assert ends == [False, False, False, False, True]


def test_a_failure_names_where_forces_are_out_of_balance(table):
    """A node is pushed far out of its place; the first iteration cannot mend that and is the only one allowed."""
    problem, newton = build(table | {"solver": {"max_iterations": 1}})
    points = problem.space.tabulate_dof_coordinates()
    step_of(problem).begin(0.0, 1.0)
    problem.displacement.x.array.reshape(-1, 3)[np.all(np.isclose(points, [6e-3, 3e-3, 2e-3]), axis=1), 0] = 5e-5
    outcome = newton.solve()
    assert not outcome.converged
    assert "in 1 iterations" in outcome.reason
    assert "N unbalanced, most at (" in outcome.reason
    assert len(set(COMM.allgather(outcome.reason))) == 1
