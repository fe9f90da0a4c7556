"""Main effects against closed forms: an additive function's shares, and an input that does nothing."""

import itertools

import numpy as np
import pytest

from ncf_fenicsx.sweeps.effects import conclusion, effects
from ncf_fenicsx.sweeps.inputs import Column, Input
from ncf_fenicsx.sweeps.outcomes import RESULTS
from ncf_fenicsx.sweeps.pictures import draw_effects, draw_interactions, draw_parallel
from ncf_fenicsx.sweeps.samples import Samples

pytestmark = pytest.mark.serial


def column(name, *levels):
    return Input((Column(name),), tuple((repr(float(level)),) for level in levels))


def test_shares_of_a_sum_on_a_grid_are_exact():
    inputs = [column("a", 0, 1), column("b", 0, 1, 2), column("c", 0, 1)]
    points = [tuple(map(repr, point)) for point in itertools.product([0.0, 1.0], [0.0, 1.0, 2.0], [0.0, 1.0])]
    values = np.array([3 * float(a) + float(b) for a, b, _ in points])
    found = effects(inputs, Samples(points, {"y": values}, {}), "y")
    variances = 9 / 4, 2 / 3, 0
    assert [one.share for one in found] == pytest.approx([part / sum(variances) for part in variances], abs=1e-12)
    assert found[0].means == pytest.approx([1, 4])
    assert found[1].means == pytest.approx([1.5, 2.5, 3.5])
    assert conclusion("force", found) == "of the variance of the force carries a 77 %, b 23 %, c 0 %"


def test_what_two_inputs_do_together_is_left_over():
    inputs = [column("a", -1, 1), column("b", -1, 1)]
    points = [tuple(map(repr, point)) for point in itertools.product([-1.0, 1.0], [-1.0, 1.0])]
    values = np.array([float(a) * float(b) for a, b in points])
    found = effects(inputs, Samples(points, {"y": values}, {}), "y")
    assert [one.share for one in found] == pytest.approx([0, 0], abs=1e-12)
    assert "100 % lie in what they do together" in conclusion("force", found)


def test_many_values_are_put_into_slices_without_a_bias_for_what_does_nothing():
    numbers = np.random.default_rng(1).random((600, 2))
    inputs = [Input((Column(name),), (), (0.0, 1.0)) for name in ("a", "b")]
    points = [tuple(map(repr, point)) for point in numbers.tolist()]
    values = numbers[:, 0].copy()
    values[5] = np.nan
    found = effects(inputs, Samples(points, {"y": values}, {}), "y")
    assert found[0].share == pytest.approx(1 - 1 / 36, abs=0.01)  # what six slices of a straight line leave
    assert found[1].share < 0.01


def test_pictures_are_drawn_of_numbers_and_words_and_of_runs_without_a_result(tmp_path):
    inputs = [column("a", 1, 2), Input((Column("kind"),), (("x",), ("y",)))]
    points = [("1.0", "x"), ("2.0", "x"), ("1.0", "y"), ("2.0", "y")]
    values = {measure.heading: np.array([1.0, 2.0, 4.0, np.nan]) for measure in RESULTS}
    samples = Samples(points, values, {"done": 3, "stopped": 1})
    draw_effects(inputs, samples, list(RESULTS), tmp_path / "effects.png")
    draw_interactions(inputs, samples, RESULTS[0], tmp_path / "interactions.png")
    draw_parallel(inputs, samples, list(RESULTS), tmp_path / "parallel.png")
    assert all(path.stat().st_size > 5e3 for path in tmp_path.glob("*.png"))
    assert samples.in_words == "4 runs: 3 done, 1 stopped"
