"""Screening and Sobol's indices against closed forms, through workers, rows and tables."""

import math

import numpy as np
import pytest
import stand_in_runs

from ncf_fenicsx import SceneError
from ncf_fenicsx.output.safe_files import ResultError
from ncf_fenicsx.sweeps import germs, morris, sobol, surrogate
from ncf_fenicsx.sweeps.inputs import Column, Input
from ncf_fenicsx.sweeps.outcomes import FORCE
from ncf_fenicsx.sweeps.pictures import draw_estimates
from ncf_fenicsx.sweeps.plans import shared
from ncf_fenicsx.sweeps.samples import Samples
from ncf_fenicsx.sweeps.sensitivity import Design, in_words
from ncf_fenicsx.workers.cluster import Place
from ncf_fenicsx.workers.engine import run_missing

pytestmark = pytest.mark.serial
PARTS = (1 + 0.1 * math.pi**4 / 5) ** 2 / 2, 49 / 8, 8 * 0.01 * math.pi**8 / 225
"""Variance of Ishigami's function by x alone, by y alone, by x and z together (Homma and Saltelli 1996)."""
FIRST = np.array([PARTS[0], PARTS[1], 0]) / sum(PARTS)
TOTAL = np.array([PARTS[0] + PARTS[2], PARTS[1], PARTS[2]]) / sum(PARTS)


def inputs(low, high):
    return [Input((Column(name),), (), (low, high)) for name in "abc"]


def through_the_engine(folder, work, design, varied):
    plan = shared(varied, design.shares)
    with Place(workers=1).opened() as connection:
        run_missing(plan.points(), plan.headings, ["y", "ending", "reason"], work, connection, folder / "rows.csv")
    samples = Samples.read(folder / "rows.csv", ["a", "b", "c"], ["y"])
    return design.indices(samples.at(list(plan.points()), "y"))


def values_of(found, name):
    return np.array([one[name].value for one in found])


def test_sobol_of_ishigami_through_the_whole_engine(tmp_path):
    design = Design.of("chaos", 3, 256, 1)
    found, unexplained = through_the_engine(tmp_path, stand_in_runs.ishigami, design, inputs(-math.pi, math.pi))
    assert values_of(found, "first") == pytest.approx(FIRST, rel=0.02, abs=1e-3)
    assert values_of(found, "total") == pytest.approx(TOTAL, rel=0.02)
    assert unexplained < 1e-4
    words = in_words(FORCE, inputs(0, 1), found, unexplained)
    assert "carries b 44 %, a 31 %, c 0 %; 24 % lie in what they do together; the surrogate leaves" in words


def test_morris_of_a_linear_scene_is_exact_through_the_whole_engine(tmp_path):
    design = Design.of("morris", 3, 20, 1)
    assert len(design.shares) == 20
    found, unexplained = through_the_engine(tmp_path, stand_in_runs.linear, design, inputs(-1, 3))
    assert unexplained is None
    assert values_of(found, "mean") == pytest.approx([12, -8, 0], abs=1e-9)
    assert values_of(found, "mean size") == pytest.approx([12, 8, 0], abs=1e-9)
    assert values_of(found, "deviation") == pytest.approx([0, 0, 0], abs=1e-9)
    assert in_words(FORCE, inputs(0, 1), found, None).endswith("a 12 N, b 8 N, c 0 N")


def ishigami(shares):
    x, y, z = (-math.pi + 2 * math.pi * shares).T
    return np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


def test_direct_indices_have_intervals_that_hold_the_true_ones():
    design = Design.of("sobol", 3, 5000, 1)
    found, _ = design.indices(ishigami(design.shares))
    for name, true in (("first", FIRST), ("total", TOTAL)):
        for one, number in zip(found, true, strict=True):
            assert one[name].low <= number <= one[name].high
            assert one[name].high - one[name].low < 0.2


def test_kriging_tells_its_own_error():
    where = germs.latin_hypercube(["share"] * 3, 60, 1)
    smooth = surrogate.fit("kriging", ["share"] * 3, where, 2 * where[:, 0] + where[:, 1] ** 2)
    rough = surrogate.fit("kriging", ["share"] * 3, where, ishigami(where))
    assert smooth.unexplained < 1e-3 < 0.1 < rough.unexplained
    variances = np.array([4 / 12, 4 / 45, 0])
    assert smooth.indices[:, 0] == pytest.approx(variances / variances.sum(), abs=0.02)


def test_a_chaos_of_normal_variables_knows_their_variances():
    kinds = ["normal", "share"]
    where = germs.latin_hypercube(kinds, 60, 1)
    fitted = surrogate.fit("chaos", kinds, where, 3 * where[:, 0] + where[:, 1])
    assert fitted.indices[:, 1] == pytest.approx([9 / (9 + 1 / 12), 1 / 12 / (9 + 1 / 12)], rel=1e-6)
    assert fitted.predict(np.array([[2.0, 0.5]])) == pytest.approx([6.5])


def test_morris_on_a_grid_of_four_values_steps_one_input_at_a_time():
    shares = morris.trajectories(4, 7, 2)
    assert np.unique(shares.round(9)).tolist() == pytest.approx([0, 1 / 3, 2 / 3, 1])
    steps = np.diff(shares.reshape(7, 5, 4), axis=1)
    assert (np.count_nonzero(steps, axis=2) == 1).all()
    assert (np.count_nonzero(steps, axis=1) == 1).all()
    effects = morris.elementary_effects(shares, shares[:, 0] * shares[:, 1])
    assert effects[2] == pytest.approx(np.zeros(7))
    assert effects[0].std() > 0.1


def test_runs_without_a_result():
    design = Design.of("morris", 2, 30, 1)
    values = design.shares[:, 0].copy()
    values[4] = np.nan
    found, _ = design.indices(values)
    assert found[0]["mean"].value == pytest.approx(1)
    design = Design.of("sobol", 2, 64, 1)
    with pytest.raises(ResultError, match="1 of 64 runs have no result"):
        design.indices(np.r_[np.nan, np.zeros(63)])
    design = Design.of("chaos", 2, 30, 1)
    with pytest.raises(ResultError, match="10 runs have a result; a surrogate needs at least 20"):
        design.indices(np.r_[np.full(20, np.nan), np.arange(10.0)])


@pytest.mark.parametrize(
    ("method", "runs", "expected"),
    [
        ("guess", 10, "expected one of morris"),
        ("morris", 5, "at least 8"),
        ("sobol", 9, "at least 10"),
        ("chaos", 19, "20"),
    ],
)
def test_designs_need_a_method_and_runs(method, runs, expected):
    with pytest.raises(SceneError, match=expected):
        Design.of(method, 3, runs, 1)


def test_the_same_seed_gives_the_same_points():
    for method in ("morris", "sobol", "chaos"):
        one, two, other = (Design.of(method, 3, 50, seed).shares for seed in (1, 1, 2))
        assert np.array_equal(one, two)
        assert not np.array_equal(one, other)


def test_bars_are_drawn(tmp_path):
    design = Design.of("sobol", 3, 500, 1)
    draw_estimates(inputs(0, 1), {FORCE: design.indices(ishigami(design.shares))[0]}, tmp_path / "bars.png")
    assert (tmp_path / "bars.png").stat().st_size > 5e3
    assert sobol.points(["share"], 4, 1).shape == (12, 1)
