"""Synthetic tests with the paper's constants, and what a fit makes of them."""

import numpy as np
import pytest
from scipy.stats import binom
from synthetic import PAPER, press, specimens

from ncf_fenicsx.calibration.fabric_writer import unsure_in_words
from ncf_fenicsx.calibration.fitting import fit_compaction
from ncf_fenicsx.calibration.free_parameters import free_of, value_of, with_values
from ncf_fenicsx.calibration.specimens import Machine
from ncf_fenicsx.laws.compaction import Exponential

pytestmark = pytest.mark.serial
TRUE = {name: value_of(PAPER, name) for name in ("compaction.beta2", "compaction.beta3", "rate.alpha1", "rate.alpha2")}
BEGIN = {"compaction.beta2": 1.4, "compaction.beta3": 0.0, "rate.alpha1": 0.2, "rate.alpha2": 2.5}


def fitted(tests, weight="thickness", fit_machine=(), machine=Machine()):  # noqa: B008
    return fit_compaction(tests, with_values(PAPER, BEGIN), free_of(PAPER, [], []), machine, list(fit_machine), weight)


@pytest.mark.parametrize("weight", ["thickness", "pressure"])
def test_without_noise_the_constants_come_back(weight):
    fit = fitted(specimens(None), weight)
    assert dict(zip(fit.names, fit.values, strict=True)) == pytest.approx(TRUE, rel=1e-3)
    assert fit.scatter < 1e-4


def hits(seed, weight="thickness"):
    fit = fitted(specimens(np.random.default_rng(seed)), weight)
    return np.abs(fit.values - list(TRUE.values())) < 1.96 * fit.errors


def test_the_constants_are_within_their_errors():
    """Of 12 draws; a slow test has 200."""
    counts = np.sum([hits(seed) for seed in range(12)], axis=0)
    assert np.all(counts >= binom.ppf(0.001, 12, 0.95))


TOLD = {
    "usual": (PAPER, ["compaction.beta2", "compaction.beta3", "rate.alpha1", "rate.alpha2"]),
    "base, transition": (PAPER, ["compaction.beta1", "compaction.beta3", "rate.alpha3", "rate.sigma_inf"]),
    "five, alpha3": (PAPER, ["compaction.beta2", "compaction.beta3", "rate.alpha1", "rate.alpha2", "rate.alpha3"]),
    "five, sigma_0": (PAPER, ["compaction.beta2", "compaction.beta3", "rate.alpha1", "rate.alpha2", "rate.sigma_0"]),
    "as printed": (
        PAPER | {"compaction": Exponential(toe="raw")},
        ["compaction.beta2", "compaction.beta3", "compaction.beta4", "rate.alpha1", "rate.alpha2"],
    ),
}
"""Numbers that such tests tell when the others are known: each of the paper's constants is in one of these."""


@pytest.mark.slow
@pytest.mark.parametrize("weight", ["thickness", "pressure"])
@pytest.mark.parametrize("case", TOLD)
def test_the_constants_are_within_their_errors_in_95_of_100_draws(case, weight):
    laws, names = TOLD[case]
    true, counts = np.array([value_of(laws, name) for name in names]), np.zeros(len(names))
    for seed in range(200):
        fit = fit_compaction(specimens(np.random.default_rng(seed), laws), laws, names, Machine(), [], weight)
        counts += np.abs(fit.values - true) < 1.96 * fit.errors
    print(case, weight, dict(zip(names, counts / 200, strict=True)))
    assert np.all((binom.ppf(0.0005, 200, 0.95) <= counts) & (counts <= binom.ppf(0.9995, 200, 0.95)))


def free_fit(*names, tests=None):
    usual = TOLD["usual"][1]
    more = [name for name in names if name not in usual]
    return fit_compaction(
        tests or specimens(np.random.default_rng(0)), PAPER, [*usual, *more], Machine(), [], "thickness"
    )


def test_the_base_of_the_exponential_is_not_told_apart_from_its_exponent():
    fit = free_fit("compaction.beta1")
    assert fit.untold == {("compaction.beta2", "compaction.beta3", "compaction.beta1"): 2}
    one, other = fit.names.index("compaction.beta1"), fit.names.index("compaction.beta2")
    assert np.abs(fit.correlations[one, other]) > 0.9999
    assert fit.errors[one] > 1e5 * fit.values[one]
    assert fit.errors[fit.names.index("rate.alpha1")] < 0.05 * fit.values[fit.names.index("rate.alpha1")]
    words = "\n".join(unsure_in_words(fit))
    assert words.startswith("these tests tell 2 of 3 numbers, compaction.beta2, compaction.beta3, compaction.beta1")


def test_what_the_shift_cancels_is_not_told_and_stays():
    fit = free_fit("compaction.beta4")
    assert fit.untold == {("compaction.beta4",): 0}
    assert fit.laws["compaction"].beta4 == PAPER["compaction"].beta4
    assert fit.errors[fit.names.index("compaction.beta4")] > 1e8
    assert "these tests say nothing of compaction.beta4" in unsure_in_words(fit)[0]


def test_only_the_ratio_of_the_two_stresses_of_the_rate_is_told():
    assert free_fit("rate.sigma_0", "rate.sigma_inf").untold == {("rate.sigma_0", "rate.sigma_inf"): 1}


def test_all_four_numbers_of_the_rate_are_hardly_told():
    fit = free_fit("rate.alpha3", "rate.sigma_inf")
    assert fit.untold == {}
    words = " ".join(unsure_in_words(fit))
    assert "these tests hardly tell rate.alpha1: its error is" in words
    assert "these tests hardly tell rate.alpha3: its error is" in words


def test_two_speeds_do_not_tell_two_numbers_of_the_rate():
    rng = np.random.default_rng(0)
    fit = free_fit(tests=[press(PAPER, 1, 4, speed, rng) for speed in (1, 5)])
    assert fit.untold == {("compaction.beta3", "rate.alpha1", "rate.alpha2"): 2}


def test_compliance_and_slack_are_found():
    tests = [
        press(PAPER, 1, thickness, speed, None, Machine(2e-7, 5e-5)) for thickness, speed in ((4, 1), (8, 2), (4, 5))
    ]
    fit = fitted(tests, "pressure", ["machine.compliance", "machine.slack"])
    assert fit.machine.compliance == pytest.approx(2e-7, rel=0.02)
    assert fit.machine.slack == pytest.approx(5e-5, rel=0.02)
    assert fit.values[0] == pytest.approx(TRUE["compaction.beta2"], rel=0.01)
