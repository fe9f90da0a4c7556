"""Synthetic tests with the paper's constants, and what a fit makes of them."""

import numpy as np
import pytest
from scipy.stats import binom
from synthetic import PAPER, press, specimens

from ncf_fenicsx.calibration.fitting import fit_compaction
from ncf_fenicsx.calibration.free_parameters import free_of, value_of, with_values
from ncf_fenicsx.calibration.specimens import Machine

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


@pytest.mark.slow
@pytest.mark.parametrize("weight", ["thickness", "pressure"])
def test_the_constants_are_within_their_errors_in_95_of_100_draws(weight):
    counts = np.sum([hits(seed, weight) for seed in range(200)], axis=0)
    print(weight, counts / 200)
    assert np.all((binom.ppf(0.0005, 200, 0.95) <= counts) & (counts <= binom.ppf(0.9995, 200, 0.95)))


def test_compliance_and_slack_are_found():
    tests = [
        press(PAPER, 1, thickness, speed, None, Machine(2e-7, 5e-5)) for thickness, speed in ((4, 1), (8, 2), (4, 5))
    ]
    fit = fitted(tests, "pressure", ["machine.compliance", "machine.slack"])
    assert fit.machine.compliance == pytest.approx(2e-7, rel=0.02)
    assert fit.machine.slack == pytest.approx(5e-5, rel=0.02)
    assert fit.values[0] == pytest.approx(TRUE["compaction.beta2"], rel=0.01)
