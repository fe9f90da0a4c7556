"""Distributions of inputs against their closed forms, a calibration's covariance, and what results become of them."""

import math

import numpy as np
import pytest
import tomli_w
from program import DEMOS

from ncf_fenicsx import SceneError
from ncf_fenicsx.cli.many_runs import uncertainty_command
from ncf_fenicsx.sweeps.distributions import Uncertain, of_fit, parse_uncertain
from ncf_fenicsx.sweeps.inputs import Column, Reader
from ncf_fenicsx.sweeps.outcomes import FORCE
from ncf_fenicsx.sweeps.pictures import draw_distributions
from ncf_fenicsx.sweeps.uncertainty import Draw, described, in_words

pytestmark = pytest.mark.serial
FILE = DEMOS / "long_roller.toml"
READER = Reader(FILE, ("laws.compaction.kind=exponential",))


def values(inputs, runs=4000):
    return np.array(list(Draw.of(inputs, "direct", runs, 1).plan.points()), dtype=float)


@pytest.mark.parametrize(
    ("text", "mean", "deviation"),
    [
        ("laws.shear.modulus=normal(1 MPa, 100 kPa)", 1e6, 1e5),
        ("laws.shear.modulus=normal(1 MPa, 10 %)", 1e6, 1e5),
        ("laws.shear.modulus=normal(1, 0.1 MPa)", 1e6, 1e5),
        ("tool.radius=uniform(2, 5 mm)", 3.5e-3, 3e-3 / math.sqrt(12)),
        ("tool.radius=triangular(2, 3, 5 mm)", 10e-3 / 3, math.sqrt((4 + 9 + 25 - 6 - 10 - 15) / 18) * 1e-3),
        ("laws.in_plane.poisson=uniform(0.1, 0.3)", 0.2, 0.2 / math.sqrt(12)),
    ],
)
def test_moments(text, mean, deviation):
    drawn = values([parse_uncertain(READER, text)])[:, 0]
    assert drawn.mean() == pytest.approx(mean, rel=2e-3)
    assert drawn.std() == pytest.approx(deviation, rel=1e-2)


def test_a_lognormal_has_its_median_and_factor():
    drawn = values([parse_uncertain(READER, "laws.shear.modulus=lognormal(1 MPa, 1.5)")])[:, 0]
    assert np.median(drawn) == pytest.approx(1e6, rel=2e-3)
    assert np.log(drawn).std() == pytest.approx(math.log(1.5), rel=1e-2)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("laws.shear.modulus=1 MPa", "expected KEY=KIND"),
        ("laws.shear.modulus=gamma(1 MPa, 2)", "normal, lognormal, uniform, triangular"),
        ("laws.shear.modulus=normal(1 MPa)", "1 numbers; expected 2 of normal"),
        ("laws.shear.modulus=normal(1 MPa, 2 mm)", "expected a mean, and a deviation"),
        ("laws.shear.modulus=normal(1 MPa, -1 kPa)", "expected a mean, and a deviation"),
        ("laws.shear.modulus=lognormal(1 MPa, 0.5)", "a factor above 1"),
        ("tool.radius=uniform(3, 2 mm)", "a lower end below the upper"),
        ("tool.radius=triangular(2, 1, 3 mm)", "in their order"),
        ("tool.radius=normal(2 mm, 2 mm)", "2 standard deviations from the middle: .*expected a positive length"),
        ("tool.radiuss=normal(2 mm, 1 mm)", "radiuss"),
    ],
)
def test_what_is_no_distribution_is_one_line(text, expected):
    with pytest.raises(SceneError, match=expected) as caught:
        parse_uncertain(READER, text)
    assert "\n" not in str(caught.value)


def fabric(folder, **changes):
    fit = {
        "names": ["shear.modulus", "machine.slack", "in_plane.modulus"],
        "values": [1e5, 1e-4, 2e11],
        "covariance": [[1e8, 1.0, 6e13], [1.0, 1e-9, 2.0], [6e13, 2.0, 1e20]],
    }
    path = folder / "fabric.toml"
    path.write_text(tomli_w.dumps({"title": "fitted", "fit": fit | changes}), encoding="utf-8")
    return path


def test_a_calibration_has_its_means_and_covariance_without_the_machine(tmp_path):
    made = of_fit(READER, fabric(tmp_path))
    assert [column.heading for column in made.columns] == ["laws.shear.modulus [Pa]", "laws.in_plane.modulus [Pa]"]
    drawn = values([made])
    assert drawn.mean(axis=0) == pytest.approx([1e5, 2e11], rel=1e-3)
    covariance = np.cov(drawn.T)
    assert covariance / [[1e8, 6e13], [6e13, 1e20]] == pytest.approx(np.ones((2, 2)), rel=0.05)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"covariance": [[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [2.0, 0.0, 1.0]]}, "expected a positive definite matrix"),
        ({"names": ["machine.a", "machine.b", "machine.c"]}, "has no fitted numbers"),
        ({"names": ["shear.none", "machine.slack", "in_plane.modulus"]}, "laws.shear.none: not in the scene"),
    ],
)
def test_a_fit_that_does_not_fit_is_one_line(tmp_path, changes, expected):
    with pytest.raises(SceneError, match=expected):
        of_fit(READER, fabric(tmp_path, **changes))


def two():
    return [Uncertain((Column("a"),), "normal", (3.0, 2.0)), Uncertain((Column("b"),), "uniform", (0.0, 6.0))]


@pytest.mark.parametrize("method", ["direct", "chaos"])
def test_a_sum_of_two_has_the_moments_of_both(method):
    draw = Draw.of(two(), method, 400 if method == "direct" else 40, 1)
    points = np.array(list(draw.plan.points()), dtype=float)
    drawn, fitted = draw.distribution(points.sum(axis=1))
    found = described(drawn, 1)
    for name, true in (("mean", 6.0), ("deviation", math.sqrt(7))):
        assert found[name].value == pytest.approx(true, rel=0.05)
        assert found[name].low < found[name].value < found[name].high
    words = in_words(FORCE, found, two(), fitted)
    assert words.startswith("the largest force on the tool is ")
    assert ("carries a 57 %, b 43 %" in words) == (method == "chaos")


def test_intervals_hold_the_true_numbers_about_as_often_as_they_say():
    random, held = np.random.default_rng(3), 0
    for seed in range(100):
        found = described(random.normal(5, 1, 60), seed)
        held += found["mean"].low <= 5 <= found["mean"].high
    assert 88 <= held <= 100


def test_distributions_are_drawn(tmp_path):
    drawn = np.random.default_rng(1).normal(size=300)
    draw_distributions({FORCE: drawn}, {FORCE: described(drawn, 1)}, tmp_path / "all.png")
    assert (tmp_path / "all.png").stat().st_size > 5e3


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({}, "expected --vary KEY=KIND"),
        ({"varied": ["tool.radius=uniform(2, 3 mm)"], "method": "guess"}, "expected one of direct, chaos, kriging"),
        ({"varied": ["tool.radius=uniform(2, 3 mm)"], "runs": 5}, "too few"),
        ({"varied": ["tool.radius=uniform(2, 3 mm)"] * 2}, "has two distributions"),
        ({"fit": FILE.with_name("none.toml")}, "expected a scene file"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(tmp_path, words, expected):
    with pytest.raises(SceneError, match=expected):
        uncertainty_command(FILE, out=tmp_path / "out", **words)
    assert not any(tmp_path.iterdir())
