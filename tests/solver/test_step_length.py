"""How much of a correction is taken, by the work along it: alone, and where faces stick and slip in turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ncf_fenicsx import Scene
from ncf_fenicsx.solver.step_length import LEFT, MOST, share_of_step

pytestmark = pytest.mark.serial


def counted(work):
    shares = []

    def and_count(share):
        shares.append(share)
        return work(share)

    return and_count, shares


def test_a_correction_near_the_solution_is_whole_and_costs_one_evaluation():
    work, shares = counted(lambda share: 1 - share)
    assert share_of_step(1.0, work) == 1.0
    assert shares == [1.0]


def test_where_the_work_grows_or_there_is_no_descent_all_is_taken():
    assert share_of_step(1.0, lambda share: 1 + share) == 1.0
    assert share_of_step(-1.0, lambda _: pytest.fail("not asked for")) == 1.0


@given(zero=st.floats(1e-3, 0.6), power=st.sampled_from([1, 2, 3]))
def test_a_correction_that_goes_too_far_ends_where_little_work_is_left(zero, power):
    def smooth(share):
        return 1 - (share / zero) ** power

    work, shares = counted(smooth)
    share = share_of_step(1.0, work)
    assert share == 1.0 or abs(smooth(share)) <= LEFT or len(shares) > MOST
    assert 0 < share <= 1


@given(jump=st.floats(0.02, 0.98))
def test_where_the_work_jumps_the_share_comes_near_the_jump(jump):
    share = share_of_step(1.0, lambda share: 1.0 if share < jump else -30.0)
    assert share == pytest.approx(jump, abs=0.1)


@pytest.mark.parametrize(("search", "converges"), [(False, False), (True, True)])
def test_whole_corrections_of_a_spring_that_slips_go_back_and_forth(search, converges):
    """A body of stiffness 0.01 on a stick of stiffness 100 that slips at a force of 1, let go where it slips."""

    def force(u):
        return 0.1 - 0.01 * u - np.clip(100 * u, -1, 1)

    u = 0.5
    for _ in range(10):
        step = force(u) / (0.01 + 100 * (abs(100 * u) < 1))
        u += step * (share_of_step(force(u) * step, lambda s: force(u + s * step) * step) if search else 1)  # noqa: B023
    assert (abs(force(u)) < 1e-12) == converges


def test_a_correction_beyond_the_laws_range_is_shortened_into_it():
    share = share_of_step(1.0, lambda s: 1 - s if s < 0.3 else np.nan)
    assert 0 < share < 0.3


FRICTION = {"friction": {"coefficient": 0.3}}
TIME = {"duration": "1 s"}


def test_friction_asks_for_a_search_and_more_iterations_unless_they_are_given():
    scene = Scene.from_table({"mould": {"kind": "plate"} | FRICTION} | TIME)
    plain = Scene.from_table({"mould": {"kind": "plate"}} | TIME)
    given_ = Scene.from_table({"mould": {"kind": "plate"} | FRICTION, "solver": {"max_iterations": 7}} | TIME)
    assert (plain.solver.line_search, plain.solver.max_iterations) == ("full", 15)
    assert (scene.solver.line_search, scene.solver.max_iterations) == ("work", 55)
    assert (given_.solver.line_search, given_.solver.max_iterations) == ("work", 7)
    assert Scene.from_table(scene.table()).solver == scene.solver
