"""Compaction pressure against the paper's figures, closed forms and finite differences."""

import numpy as np
import pytest
from laws_by_number import MM_PER_MIN, VF0, in_step, law
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

from ncf_fenicsx import Scene
from ncf_fenicsx.laws.compaction import Exponential, Table
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.rate import KellyRate
from ncf_fenicsx.parameters.kinds import kinds

pytestmark = pytest.mark.serial
LAWS = [kind() for kind in kinds("compaction").values()]
LAWS += [Exponential(toe="clip"), Exponential(toe="raw")]
STRESS_FREE = [made for made in LAWS if getattr(made, "toe", "") != "raw"]


def name(made):
    return f"{made.kind}-{getattr(made, 'toe', '')}"


def test_the_printed_curve_is_tensile_in_the_undeformed_fabric_and_the_options_are_not():
    raw, clip, shift = (Exponential(toe=toe) for toe in ("raw", "clip", "shift"))
    assert raw.pressure(VF0, VF0) == pytest.approx(-962, abs=0.5)
    assert raw.pressure(0.429852, VF0) == pytest.approx(0.0, abs=0.02)
    assert clip.pressure(VF0, VF0) == shift.pressure(VF0, VF0) == 0
    vf = np.linspace(0.46, 0.7, 30)
    assert shift.pressure(vf, VF0) - raw.pressure(vf, VF0) == pytest.approx(np.full(30, 962), abs=0.5)
    assert np.abs(clip.pressure(vf, VF0) - raw.pressure(vf, VF0)).max() < 20
    assert clip.pressure(0.415, VF0) < 20  # the toe is gone
    slopes = np.diff(clip.pressure(np.linspace(0.38, 0.5, 4001), VF0))
    assert np.all(slopes > 0)
    assert np.abs(np.diff(slopes) / slopes[1:]).max() < 0.02  # and the corner is round


@pytest.mark.parametrize("made", LAWS, ids=name)
def test_pressure_grows_with_the_volume_fraction(made):
    vf = np.linspace(0.35, min(0.75, 0.99 * made.packing_limit), 400)
    assert np.all(np.diff(made.pressure(vf, VF0)) > 0)
    if made in STRESS_FREE:
        assert made.pressure(VF0, VF0) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("made", [made for made in STRESS_FREE if made.kind != "gutowski"], ids=name)
def test_the_defaults_of_the_alternatives_meet_the_papers_curve(made):
    if getattr(made, "toe", "") != "clip":
        for vf in (0.5, 0.6):
            assert made.pressure(vf, VF0) == pytest.approx(Exponential().pressure(vf, VF0), rel=2e-3)


@pytest.mark.parametrize("made", LAWS, ids=name)
@pytest.mark.parametrize("vf", [0.39, 0.403, 0.47, 0.58, 0.66])
def test_pressure_is_the_derivative_of_the_energy(made, vf):
    """d energy / d lambda_3 = -pressure, with lambda_3 = Vf0 / Vf."""
    stretch, step = VF0 / vf, 1e-6
    low, high = (made.energy(VF0 / (stretch + sign * step), VF0) for sign in (-1, 1))
    assert -(high - low) / (2 * step) == pytest.approx(made.pressure(vf, VF0), rel=1e-6, abs=1e-4)


@pytest.mark.parametrize("made", LAWS, ids=name)
def test_energy_is_the_work_of_the_pressure(made):
    knots = [0.40, 0.42, 0.46, 0.5, 0.55]
    work, _ = quad(lambda vf: made.pressure(vf, VF0) * VF0 / vf**2, VF0, 0.6, points=knots, epsabs=1e-12)
    assert made.energy(0.6, VF0) == pytest.approx(work, rel=1e-8)


@pytest.mark.parametrize("made", LAWS, ids=name)
@pytest.mark.parametrize("stretch", [0.97, 0.8, 0.65])
def test_tangent_is_the_derivative_over_the_thickness_stretch(made, stretch):
    step = 1e-6
    slope = (made.pressure(VF0 / (stretch + step), VF0) - made.pressure(VF0 / (stretch - step), VF0)) / (2 * step)
    assert made.tangent(VF0 / stretch, VF0) == pytest.approx(-slope, rel=1e-6)


@pytest.mark.parametrize("made", LAWS, ids=name)
def test_formulas_hold_for_symbols_as_for_numbers(made):
    step = in_step(made, 0.57)
    assert number(step.loading(step.volume_fraction)) == pytest.approx(made.pressure(0.57, VF0), rel=1e-14)


def test_closed_forms():
    power, offset = law("compaction", "power"), law("compaction", "offset_power", toe=1e-9)
    assert power.pressure(0.6, VF0) == pytest.approx(6.97455e6 * (0.6**9.93265 - VF0**9.93265))
    assert offset.pressure(0.6, VF0) == pytest.approx((225.8515 * (0.6 - VF0)) ** 2.791795, rel=1e-6)
    gutowski = law("compaction", "gutowski", spring="280 Pa", limit=0.70)
    expected = 280 * (np.sqrt(0.6 / VF0) - 1) / (np.sqrt(0.7 / 0.6) - 1) ** 4
    assert gutowski.pressure(0.6, VF0) == pytest.approx(expected, rel=1e-12)
    assert gutowski.pressure(0.6999, VF0) > 1e6 * gutowski.pressure(0.6, VF0)


def test_the_table_is_pchip_through_its_points_and_shifted_to_zero():
    made = Table()
    vf, stress = np.array(made.volume_fraction), np.array(made.stress)
    assert made.caution(Scene.from_table({"duration": "1 s"}).conditions) is None  # its data is zero at Vf0, nearly
    inner = np.linspace(0.40, 0.60, 61)  # the outer slopes are held above a tenth of the secant's
    reference = PchipInterpolator(vf, stress)
    at_rest = made.pressure(0.45, VF0) - reference(0.45)
    assert made.pressure(inner, VF0) - at_rest == pytest.approx(reference(inner), rel=1e-12)
    assert made.pressure(vf, VF0) - at_rest == pytest.approx(stress, rel=1e-12)


def test_a_table_that_starts_flat_or_above_zero():
    """Flat ends keep some slope, and what is not zero at Vf0 is moved, and said."""
    made = law(
        "compaction", "table", volume_fraction=[0.38, 0.5, 0.6, 0.7], stress=["1 Pa", "1.1 Pa", "50 kPa", "51 kPa"]
    )
    vf = np.array([0.30, 0.34, 0.38, 0.72, 0.76])
    assert np.all(np.diff(made.pressure(vf, VF0)) > 0.09 * np.array([0.83, 0.83, 1e4, 1e4]) * np.diff(vf))
    high = {"kind": "table", "volume_fraction": [0.4, 0.5], "stress": ["1 kPa", "5 kPa"]}
    cautions = Scene.from_table({"duration": "1 s", "laws": {"compaction": high}}).cautions
    assert "laws.compaction: the table is moved by -921.8 Pa" in cautions[0]


@pytest.mark.parametrize(("speed", "kpa"), [(1, 27.82), (2, 41.95), (5, 77.20)])
def test_the_default_gives_back_the_curves_it_was_fitted_to(speed, kpa):
    """A specimen of 4 mm at the cross-head's speed, stepped to Vf 0.60: the local speed is that of the cross-head."""
    stretch = VF0 / 0.60
    before = stretch + speed * MM_PER_MIN * 2.0 / 4e-3
    step = in_step(Exponential(), 0.60, VF0 / before, time_step=2.0)
    pressure = number(KellyRate().apply(step, Exponential().as_printed(0.60)))
    assert pressure / 1e3 == pytest.approx(kpa, abs=1e-2)
