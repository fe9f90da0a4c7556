"""Laws given as tables, fitted: nodes from the data, entries that ascend, errors of each. And laws of users."""

import numpy as np
import pytest
from synthetic import PAPER, press, specimens

from ncf_fenicsx.calibration.calibrate import Wishes, fit_tests
from ncf_fenicsx.calibration.free_parameters import free_of, unknowns, with_values
from ncf_fenicsx.laws.compaction import CompactionLaw, Table
from ncf_fenicsx.laws.rate import RateTable
from ncf_fenicsx.parameters.kinds import _kinds, parameter

pytestmark = pytest.mark.serial


def initial_of(tests):
    return tests[0].initial_volume_fraction


def test_a_table_of_compaction_meets_the_curve_that_made_the_tests():
    tests = specimens(np.random.default_rng(3))
    fit = fit_tests(tests, Wishes({"compaction": "table"}))
    law, initial = fit.laws["compaction"], initial_of(tests)
    assert Table.model_validate(law.model_dump())
    assert law.volume_fraction[0] == pytest.approx(initial, rel=1e-5)
    assert law.volume_fraction[-1] == pytest.approx(0.6)
    vf = np.linspace(0.42, 0.6, 50)
    assert law.pressure(vf, initial) == pytest.approx(PAPER["compaction"].pressure(vf, initial), rel=0.02)
    assert np.all(fit.errors[:-2] < 0.06 * fit.values[:-2])
    assert fit.untold == {}


@pytest.mark.slow
def test_entries_of_a_table_are_within_their_errors():
    """Of a curve that a table can be: the table itself."""
    first = fit_tests(specimens(None), Wishes({"compaction": "table"}))
    made = PAPER | {"compaction": first.laws["compaction"]}
    counts = np.zeros(len(first.laws["compaction"].stress) - 1)
    for seed in range(60):
        fit = fit_tests(specimens(np.random.default_rng(seed), made), Wishes({"compaction": "table"}))
        nodes = np.array(fit.laws["compaction"].volume_fraction)
        true = made["compaction"].pressure(nodes, initial_of(specimens(None)))[1:]
        counts += np.abs(fit.values[:-2] - true) < 1.96 * fit.errors[:-2]
    assert np.all(counts >= 49)


def test_noise_does_not_make_a_table_fall():
    rng = np.random.default_rng(5)
    test = press(PAPER, 1, 4, 2)
    force = test.force * (1 + 0.3 * rng.standard_normal(len(test.force)))
    noisy = type(test)(**{**vars(test), "force": np.abs(force)})
    law = fit_tests([noisy], Wishes({"compaction": "table"})).laws["compaction"]
    assert np.all(np.diff(law.stress) > 0)


def test_a_table_of_rates_has_its_nodes_at_the_speeds_of_the_tests():
    rate = RateTable(closing_speed=["10 mm/min", "30 mm/min", "90 mm/min"], factors=[0.8, 1.0, 1.3])
    tests = [press(PAPER | {"rate": rate}, 1, 4, speed) for speed in (10, 30, 90)]
    law = fit_tests(tests, Wishes({"rate": "table"})).laws["rate"]
    assert np.array(law.closing_speed) * 6e4 == pytest.approx([10, 30, 90], rel=0.01)
    assert law.factors == pytest.approx((0.8, 1.0, 1.3), rel=2e-3)


def test_entries_before_one_that_stays_are_counted_down_from_it():
    laws = {"rate": RateTable(closing_speed=["1 m/s", "2 m/s", "3 m/s", "4 m/s"], factors=[0.5, 0.7, 1.0, 1.5])}
    names = free_of(laws, [], [])
    free = unknowns(laws, names)
    assert names == ["rate.factors.0", "rate.factors.1", "rate.factors.3"]
    assert free.begin == pytest.approx([0.2, 0.3, 0.5])
    assert with_values(laws, free.named(free.begin))["rate"].factors == pytest.approx((0.5, 0.7, 1.0, 1.5))
    for random in np.random.default_rng(1).uniform(0.01, 0.4, (20, 3)):
        assert np.all(np.diff(with_values(laws, free.named(random))["rate"].factors) > 0)


@pytest.fixture
def linear():
    class Linear(CompactionLaw):
        kind = "straight"
        slope: float = parameter(1e5, gt=0, description="pressure in Pa over the gain of Vf")

        def pressure(self, volume_fraction, initial_volume_fraction):
            return self.slope * (volume_fraction - initial_volume_fraction)

    yield Linear
    del _kinds["compaction"]["straight"]


def test_a_law_of_a_user_is_fitted_without_a_word_on_it(linear):
    made = PAPER | {"compaction": linear(slope=3e6)}
    fit = fit_tests([press(made, 1, 4, speed) for speed in (1, 2, 5)], Wishes({"compaction": "straight"}))
    assert fit.names == ["compaction.slope", "rate.alpha1", "rate.alpha2"]
    assert fit.laws["compaction"].slope == pytest.approx(3e6, rel=1e-3)
