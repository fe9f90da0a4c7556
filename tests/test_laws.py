"""Laws against the paper's figures, closed forms and finite differences."""

import numpy as np
import pytest
import ufl

from ncf_fenicsx import Scene
from ncf_fenicsx.laws.exponential import Exponential
from ncf_fenicsx.laws.kelly_rate import KellyRate
from ncf_fenicsx.laws.neo_hookean import NeoHookean

MM_PER_MIN = 1e-3 / 60
VF0 = Scene.from_table({"duration": "1 s"}).stack.initial_volume_fraction


def test_initial_volume_fraction_of_the_paper():
    assert pytest.approx(0.398045, abs=5e-7) == VF0


@pytest.mark.parametrize(
    ("vf", "kpa"), [(0.41, -0.6612), (0.45, 0.9523), (0.50, 5.4339), (0.55, 16.1798), (0.60, 41.9459), (0.65, 103.727)]
)
def test_compaction_stress_as_printed(vf, kpa):
    assert Exponential().as_printed(vf) / 1e3 == pytest.approx(kpa, abs=1e-3)


def test_shifted_compaction_stress_is_zero_at_rest_and_monotone():
    vf = np.linspace(0.3, 0.9, 200)
    pressure = Exponential().pressure(vf, VF0)
    assert Exponential().pressure(VF0, VF0) == 0
    assert np.all(np.diff(pressure) > 0)


def test_compaction_tangent_is_the_derivative_over_the_thickness_stretch():
    law, stretch, step = Exponential(), 0.8, 1e-6
    slope = (law.pressure(VF0 / (stretch + step), VF0) - law.pressure(VF0 / (stretch - step), VF0)) / (2 * step)
    assert law.tangent(VF0 / stretch, VF0) == pytest.approx(-slope, rel=1e-8)


@pytest.mark.parametrize(("speed", "growth", "kpa"), [(1, 1.10020, 27.82), (2, 1.65887, 41.95), (5, 3.05293, 77.20)])
def test_rate_factor_and_stress_at_vf_60(speed, growth, kpa):
    rate = KellyRate()
    assert rate.growth(speed * MM_PER_MIN) == pytest.approx(growth, abs=5e-6)
    assert rate.factor(speed * MM_PER_MIN) * Exponential().as_printed(0.6) / 1e3 == pytest.approx(kpa, abs=5e-3)


def test_rate_growth_has_the_limits_the_paper_defines():
    rate = KellyRate()
    assert rate.growth(0.0) == pytest.approx(1.0, rel=1e-12)
    assert rate.growth(1e6) == pytest.approx(85829 / 23726, rel=1e-6)
    assert rate.factor(rate.v_ref) == 1.0


def value(expression):
    """Number of a UFL expression without fields."""
    return float(expression(()))


def in_plane_energy(law, c):
    """Textbook plane-stress neo-Hookean energy in J/m3, written independently of the law."""
    mu = law.modulus / 2 / (1 + law.poisson)
    lame = law.modulus * law.poisson / (1 - law.poisson**2)
    log_j = np.log(np.linalg.det(c)) / 2
    return mu / 2 * (np.trace(c) - 2 - 2 * log_j) + lame / 2 * log_j**2


def test_in_plane_stress_is_the_derivative_of_its_energy():
    law, c, step = NeoHookean(), np.array([[1.02, 0.013], [0.013, 0.97]]), 1e-6
    stress = law.stress(ufl.as_matrix(c.tolist()))
    for i, j in np.ndindex(2, 2):
        change = np.zeros((2, 2))
        change[i, j] += step / 2
        change[j, i] += step / 2
        slope = (in_plane_energy(law, c + change) - in_plane_energy(law, c - change)) / (2 * step)
        assert value(stress[i, j]) == pytest.approx(2 * slope, rel=1e-6)


def test_a_pulled_strip_has_the_modulus_and_poisson_ratio_it_is_given():
    law, strain = NeoHookean(), 1e-6
    c = np.diag([(1 + strain) ** 2, (1 - law.poisson * strain) ** 2])
    stress = law.stress(ufl.as_matrix(c.tolist()))
    assert value(stress[0, 0]) == pytest.approx(law.modulus * strain, rel=1e-5)
    assert abs(value(stress[1, 1])) < 1e-5 * law.modulus * strain
