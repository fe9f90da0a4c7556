"""The rule of the viscosity alone: when it comes, grows and goes."""

from types import SimpleNamespace

import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.mechanics.time_step import USUAL, Effort, Outcome
from ncf_fenicsx.simulation.stabilisation import (
    DEEP_TROUBLE,
    EASE,
    LEAST,
    LOWER,
    PLAIN_TROUBLE,
    RAISE,
    TROUBLE,
    UNTOLD_DEEP_TROUBLE,
    UNTOLD_TROUBLE,
    Stabilisation,
)
from ncf_fenicsx.simulation.step import BRIEF, LAST_RESORT, SNAPPING, StabilisedStep
from ncf_fenicsx.simulation.stepping import FIRST_STEPS, StepControl

pytestmark = pytest.mark.serial


def rule(stability_lost=True):
    return Stabilisation(first=1e7, stability_lost=stability_lost)


def test_a_step_cut_once_is_no_trouble():
    stabilisation = rule()
    stabilisation.failed(1.0)
    stabilisation.failed(TROUBLE * 1.01)
    assert stabilisation.value == 0


def test_troubles_without_a_loss_of_stability_get_it_later():
    stabilisation = rule(stability_lost=False)
    stabilisation.failed(0.9 * TROUBLE)
    stabilisation.failed(1.01 * PLAIN_TROUBLE)
    assert stabilisation.value == 0
    stabilisation.failed(0.99 * PLAIN_TROUBLE)
    assert stabilisation.value == 1e7


def test_where_no_pivots_tell_of_stability_each_trouble_is_taken_for_its_loss():
    stabilisation = Stabilisation(first=1e7, told=False)
    stabilisation.failed(0.9 * UNTOLD_TROUBLE)
    assert stabilisation.value == 1e7
    stabilisation.failed(0.9 * UNTOLD_DEEP_TROUBLE)
    assert stabilisation.value == RAISE * 1e7


def test_it_comes_in_trouble_grows_in_deep_trouble_and_goes_where_steps_hold():
    stabilisation = rule()
    stabilisation.failed(0.9 * TROUBLE)
    stabilisation.failed(0.4 * TROUBLE)
    assert stabilisation.value == 1e7
    stabilisation.failed(0.9 * DEEP_TROUBLE)
    assert stabilisation.value == RAISE * 1e7
    stabilisation.held(0.9 * TROUBLE)
    assert stabilisation.value == RAISE * 1e7
    stabilisation.held(TROUBLE)
    assert stabilisation.value == pytest.approx(LOWER * RAISE * 1e7)
    for _ in range(50):
        stabilisation.held(TROUBLE)
    assert stabilisation.value == 0


def test_it_stays_away_where_the_scene_says_so(table):
    stabilisation = Stabilisation.of_scene(Scene.from_table(table | {"solver": {"stabilisation": "none"}}))
    stabilisation.failed(1e-6)
    assert stabilisation.value == 0


@pytest.mark.parametrize("factor", [1, 10])
def test_its_force_is_a_share_of_the_layers_own_at_any_speed(table, factor):
    path = [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": f"{factor} mm/min"}]
    laws = {"rate": {"kind": "none"}}
    scene = Scene.from_table(table | {"laws": laws, "tool": table["tool"] | {"path": path}})
    first = Stabilisation.of_scene(scene).first
    assert first * factor * 1e-3 / 60 == pytest.approx(5e-5 * scene.natural_stiffness, rel=1e-12)


@pytest.mark.parametrize("told", [True, False])
def test_it_eases_in_trouble_where_no_pivots_tell_that_it_is_over(told):
    stabilisation = Stabilisation(first=1e7, value=1e7, told=told)
    stabilisation.held(0.9 * UNTOLD_TROUBLE)
    assert stabilisation.value == pytest.approx(1e7 * (1.0 if told else EASE))
    for _ in range(1000):
        stabilisation.held(0.9 * UNTOLD_TROUBLE)
    assert stabilisation.value >= 0.9 * LEAST * 1e7


@pytest.mark.parametrize("size", [0.01, 5e-4, 2e-5])
@pytest.mark.parametrize("turns", [True, False])
@pytest.mark.parametrize(("friction", "value"), [(True, 1e7), (True, 0.0), (False, 1e7)])
def test_only_a_search_for_what_sticks_is_cut_short_and_made_exact_while_the_stack_snaps(friction, value, turns, size):
    """But not that of a short step with which a tool turns, nor of the shortest: none is nearer to the state before."""
    contact = {"mould": {"kind": "plate"} | ({"friction": {"coefficient": 0.2}} if friction else {})}
    scene = Scene.from_table(contact | {"duration": "1 s"})
    seen = []

    def attempt(_time, _size, effort, _least):
        seen.append(effort)
        return Outcome(True, 3, "converged")

    problem = SimpleNamespace(scene=scene)
    time_step = SimpleNamespace(
        problem=problem, stabilise=lambda _: None, attempt=attempt, in_same_segments=lambda _: not turns
    )
    steps = StabilisedStep(time_step, Stabilisation(first=1e7, value=value, told=not friction))
    control = StepControl.of(scene.solver, 1.0, controls_time_error=False)
    assert control.searches == friction
    steps.attempt(0.0, size, control)
    if not (friction and value):
        assert seen == [USUAL if friction or size < TROUBLE / FIRST_STEPS else Effort(may_wander=False)]
        return
    brief = BRIEF * scene.solver.target_iterations
    patient = size < LAST_RESORT / FIRST_STEPS or (turns and size < UNTOLD_TROUBLE / FIRST_STEPS)
    most = scene.solver.max_iterations if patient else brief
    assert round(seen[0].patience * scene.solver.max_iterations) == most
    assert seen[0].force_tolerance == SNAPPING
    assert seen[0].polishes


def test_where_corrections_have_wandered_shorter_steps_are_given_up_sooner_until_one_as_long_holds():
    scene = Scene.from_table({"mould": {"kind": "plate"}, "duration": "1 s"})
    seen, held, wandered = [], Outcome(True, 3, "converged"), Outcome(False, 6, "wandered", wandered=True)
    outcomes = iter([wandered, wandered, held, held, held, held, held, wandered, held])

    def attempt(_time, _size, effort, _least):
        seen.append((effort.may_wander, effort.must_shrink))
        return next(outcomes)

    time_step = SimpleNamespace(problem=SimpleNamespace(scene=scene), stabilise=lambda _: None, attempt=attempt)
    steps = StabilisedStep(time_step, Stabilisation(first=1e7))
    control = StepControl.of(scene.solver, 1.0, controls_time_error=False)
    for share in (3.0, 1.2, 0.5, 0.1, 1.1, 3.0, 2.0, 3.0, 3.0):
        steps.attempt(0.0, share * control.first, control)
    strict, usual = (False, True), (False, False)
    assert seen == [usual, strict, strict, (True, False), strict, usual, usual, usual, usual]
    assert steps.iterations == 6 + 6 + 3 + 3 + 3 + 3 + 3 + 6 + 3


def test_an_interrupted_step_is_no_failed_one():
    scene = Scene.from_table({"mould": {"kind": "plate"}, "duration": "1 s"})
    stopped, failed = Outcome(False, 1, "stopped", hopeless=True), Outcome(False, 15, "no convergence")
    outcomes = iter([stopped, failed])
    time_step = SimpleNamespace(
        problem=SimpleNamespace(scene=scene), stabilise=lambda _: None, attempt=lambda *_: next(outcomes)
    )
    steps = StabilisedStep(time_step, Stabilisation(first=1e7))
    control = StepControl.of(scene.solver, 1.0, controls_time_error=False)
    values = []
    for _ in range(2):
        steps.attempt(0.0, 1e-4 * control.first, control)
        values.append(steps.stabilisation.value)
    assert values == [0.0, 1e7]


def test_past_a_loss_of_stability_corrections_may_wander():
    scene = Scene.from_table({"mould": {"kind": "plate"}, "duration": "1 s"})
    seen = []

    def attempt(_time, _size, effort, _least):
        seen.append(effort)
        return Outcome(True, 3, "converged")

    time_step = SimpleNamespace(problem=SimpleNamespace(scene=scene), stabilise=lambda _: None, attempt=attempt)
    steps = StabilisedStep(time_step, Stabilisation(first=1e7))
    control = StepControl.of(scene.solver, 1.0, controls_time_error=False)
    for steps.stabilisation.stability_lost in (False, True):
        steps.attempt(0.0, control.first, control)
    assert seen == [Effort(may_wander=False), USUAL]


def test_where_corrections_have_wandered_is_forgotten_in_another_piece_of_the_path():
    scene = Scene.from_table({"mould": {"kind": "plate"}, "duration": "1 s"})
    seen = []

    def attempt(_time, _size, effort, _least):
        seen.append(effort.must_shrink)
        return Outcome(False, 6, "wandered", wandered=True)

    time_step = SimpleNamespace(problem=SimpleNamespace(scene=scene), stabilise=lambda _: None, attempt=attempt)
    steps = StabilisedStep(time_step, Stabilisation(first=1e7))
    for duration, share in ((1.0, 2.0), (1.0, 1.0), (100.0, 1.0), (100.0, 0.5)):
        control = StepControl.of(scene.solver, duration, controls_time_error=False)
        steps.attempt(0.0, share * control.first, control)
    assert seen == [False, True, False, True]
