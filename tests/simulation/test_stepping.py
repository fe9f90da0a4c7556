"""Step control alone: no mesh, no solver."""

from dataclasses import dataclass, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ncf_fenicsx.simulation.stepping import Ending, Piece, StepControl, march

pytestmark = pytest.mark.serial

CONTROL = StepControl(first=1.0, smallest=1e-3, largest=5.0, growth=1.5, cut=0.4, target_iterations=6, max_steps=100)


@dataclass
class Try:
    converged: bool = True
    iterations: int = 4
    reason: str = "the test says so"
    hopeless: bool = False
    time_error: float = 0.0
    too_long: bool = False


def run(attempt, milestones=(30.0,), control=CONTROL):
    accepted = []
    ended = march(
        [Piece(end, control) for end in milestones],
        attempt,
        lambda progress, size, _: accepted.append((progress.time, size)),
    )
    return ended, accepted


def test_easy_steps_grow_to_the_largest_and_land_on_the_end():
    ended, accepted = run(lambda *_: Try())
    sizes = [size for _, size in accepted]
    assert ended.ending is Ending.DONE
    assert accepted[-1][0] == 30.0
    assert sizes[:3] == pytest.approx([1.0, 1.5, 2.25])
    assert max(sizes) <= 5.0
    assert min(sizes[2:]) > 1.5  # no leftover step at the end


@given(st.lists(st.floats(0.5, 20), min_size=1, max_size=4))
def test_every_milestone_is_met_exactly(durations):
    milestones = [sum(durations[: k + 1]) for k in range(len(durations))]
    ended, accepted = run(lambda *_: Try(), milestones)
    times = [time for time, _ in accepted]
    assert ended.ending is Ending.DONE
    assert set(milestones) <= set(times)
    assert times == sorted(times)


def test_each_piece_begins_with_its_own_first_step_and_what_follows_changes_nothing_before():
    long, short = replace(CONTROL, first=8.0, largest=50.0), CONTROL
    alone, before = run(lambda *_: Try())
    both = []
    march([Piece(30.0, short), Piece(400.0, long)], lambda *_: Try(), lambda at, size, _: both.append((at.time, size)))
    assert alone.ending is Ending.DONE
    assert both[: len(before)] == before
    assert both[len(before)][1] <= 8.0
    assert max(size for _, size in both) > short.largest


def test_a_step_with_too_large_an_error_in_time_is_taken_again_as_small_as_it_has_to_be():
    control = replace(CONTROL, time_tolerance=0.01)
    tries = []

    def attempt(time, size, _=None):
        tries.append((time, size))
        error = 0.04 * size if time < 10 else 1e-6
        return Try(converged=error <= 0.01, time_error=error, too_long=error > 0.01)

    ended, accepted = run(attempt, control=control)
    assert ended.ending is Ending.DONE
    assert all(size <= 0.25 for time, size in accepted if time - size < 10)
    assert sum(time < 10 for time, _ in tries) < 10 / 0.25 * 2.2  # in bands, not far below
    assert ended.cuts <= 3  # the error of one step sets the size of the next
    assert max(size for _, size in accepted) > 3.0


def test_hard_steps_shrink_and_the_target_keeps_the_size():
    assert CONTROL.next_size(2.0, 5) == pytest.approx(3.0)
    assert CONTROL.next_size(2.0, 6) == CONTROL.next_size(2.0, 9) == 2.0
    assert CONTROL.next_size(2.0, 12) == pytest.approx(1.0)
    searching = replace(CONTROL, searches=True)
    assert searching.next_size(2.0, 10) == searching.next_size(2.0, 30) == 1.0
    assert CONTROL.next_size(8.0, 6) == CONTROL.largest
    assert CONTROL.next_size(1e-3, 60) == CONTROL.smallest


def test_a_failed_step_is_tried_again_smaller_from_the_same_time():
    tries = []

    def attempt(time, size, _=None):
        tries.append((time, size))
        return Try(converged=len(tries) != 3)

    ended, accepted = run(attempt)
    assert ended.ending is Ending.DONE
    assert ended.cuts == 1
    assert tries[3] == pytest.approx((tries[2][0], 0.4 * tries[2][1]))
    assert len(accepted) == len(tries) - 1


def test_a_march_that_cannot_go_on_says_why_and_where():
    ended, accepted = run(lambda time, size, _: Try(converged=time + size <= 10.0, reason="a wall at 10 s"))
    assert ended.ending is Ending.STOPPED
    assert "a wall at 10 s" in ended.reason
    assert ended.time == accepted[-1][0]
    assert 10.0 - 2 * CONTROL.smallest / CONTROL.cut < ended.time <= 10.0


def test_a_march_ends_after_max_steps():
    ended, accepted = run(lambda *_: Try(), [1e6])
    assert ended.ending is Ending.STOPPED
    assert "max_steps" in ended.reason
    assert len(accepted) == 100


def test_a_step_that_no_smaller_one_would_mend_ends_the_march_at_once():
    tries = []

    def attempt(time, size, _=None):
        tries.append((time, size))
        return Try(converged=time < 3, hopeless=time >= 3, reason="interrupted")

    ended, accepted = run(attempt)
    assert ended.ending is Ending.STOPPED
    assert ended.reason == "interrupted"
    assert ended.cuts == 0
    assert len(tries) == len(accepted) + 1


def test_a_step_that_may_not_be_longer_is_shortened_and_does_not_shrink_the_next():
    def longest(time, size):
        return 7.3 - time if time < 7.3 < time + size else size

    accepted = []
    ended = march(
        [Piece(30.0, CONTROL)],
        lambda *_: Try(iterations=7),
        lambda at, size, _: accepted.append((at.time, size)),
        None,
        longest,
    )
    assert ended.ending is Ending.DONE
    assert 7.3 in [time for time, _ in accepted]
    sizes = dict(accepted)
    assert sizes[7.3] == pytest.approx(0.3)
    assert sizes[8.3] == pytest.approx(1.0)


@pytest.mark.parametrize("stop", [1, 4, 7])
def test_a_march_that_goes_on_takes_the_steps_of_one_that_never_stopped(stop):
    def attempt(time, size, _=None):
        return Try(converged=size < 2.1, iterations=3 + int(time) % 7)

    whole, all_steps = run(attempt)
    states, later = [], []
    march(
        [Piece(30.0, replace(CONTROL, max_steps=stop))], attempt, lambda progress, *_: states.append(replace(progress))
    )
    ended = march(
        [Piece(30.0, CONTROL)], attempt, lambda progress, size, _: later.append((progress.time, size)), states[-1]
    )
    assert later == all_steps[stop:]
    assert (ended.time, ended.steps) == (whole.time, whole.steps)
