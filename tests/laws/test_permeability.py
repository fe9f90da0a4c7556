"""Permeability over Vf against figures worked out by hand."""

import pytest

from ncf_fenicsx.laws.permeability import Gebart, KozenyCarman

pytestmark = pytest.mark.serial

GEBART = [  # Vf, along and across in m2 at a fibre radius of 3.6 um, worked out apart from the program
    ("quadratic", 0.4, 2.4556e-12, 5.2887e-13),
    ("quadratic", 0.5, 9.0947e-13, 1.6748e-13),
    ("quadratic", 0.6, 3.2337e-13, 4.0887e-14),
    ("hexagonal", 0.4, 2.6409e-12, 5.4459e-13),
    ("hexagonal", 0.5, 9.7811e-13, 2.1202e-13),
    ("hexagonal", 0.6, 3.4777e-13, 7.5489e-14),
]


@pytest.mark.parametrize(("packing", "vf", "along", "across"), GEBART)
def test_permeability_of_gebart(packing, vf, along, across):
    law = Gebart(packing=packing)
    assert law.along(vf) == pytest.approx(along, rel=1e-4)
    assert law.across(vf) == pytest.approx(across, rel=1e-4)


def test_permeability_of_kozeny_and_carman():
    law = KozenyCarman(fibre_radius="4 um", constant_along=0.5, constant_across=8.0)
    assert law.along(0.5) == pytest.approx(16e-12 / 2 * 0.5, rel=1e-12)
    assert law.across(0.5) == pytest.approx(law.along(0.5) / 16, rel=1e-12)
