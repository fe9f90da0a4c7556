"""Transverse shear: the energy of a slide, and a modulus that follows Vf."""

import numpy as np
import pytest
from laws_by_number import law, strained

from ncf_fenicsx.laws.law import number

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("kind", ["constant", "growing"])
def test_shear_energy_of_a_slide(kind):
    made, slide = law("shear", kind, modulus="0.3 MPa"), 0.05
    F = np.eye(3)
    F[0, 2] = slide
    assert number(made.energy(strained(F))) == pytest.approx(0.3e6 / 2 * slide**2, rel=1e-12)
    assert made.small_strain_modulus == pytest.approx(0.3e6, rel=1e-9)


def test_growing_shear_follows_the_volume_fraction():
    made, F = law("shear", "growing", exponent=4.0), np.eye(3)
    F[0, 2], F[2, 2] = 0.05, 0.8
    constant = number(law("shear", "constant").energy(strained(F)))
    assert number(made.energy(strained(F))) == pytest.approx((1 / 0.8) ** 4 * constant, rel=1e-12)
    assert number(law("shear", "growing", exponent=0.0).energy(strained(F))) == pytest.approx(constant, rel=1e-12)
