"""Isotropic solids against linear elasticity and the textbook."""

import numpy as np
import pytest
from laws_by_number import DEFORMATIONS, TURN, law, strained

from ncf_fenicsx.laws.law import number
from ncf_fenicsx.mechanics.material import normal_stress_of

pytestmark = pytest.mark.serial
SOLIDS = [law("solid", kind, modulus="1 MPa", poisson=0.3) for kind in ("logarithmic", "split")]


def solid_stress(made, F):
    """First Piola-Kirchhoff stress by central differences of the energy."""
    P, step = np.zeros((3, 3)), 1e-6
    for i, j in np.ndindex(3, 3):
        change = np.zeros((3, 3))
        change[i, j] = step
        P[i, j] = (number(made.energy(strained(F + change))) - number(made.energy(strained(F - change)))) / (2 * step)
    return P


@pytest.mark.parametrize("made", SOLIDS, ids=lambda made: made.kind)
def test_solids_have_the_modulus_and_poisson_ratio_they_are_given(made):
    strain = 1e-5
    stress = solid_stress(made, np.diag([1 + strain, 1 - 0.3 * strain, 1 - 0.3 * strain]))
    assert stress[0, 0] == pytest.approx(1e6 * strain, rel=1e-3)
    assert abs(stress[1, 1]) < 1e-3 * 1e6 * strain
    held = solid_stress(made, np.diag([1, 1, 1 - strain]))
    assert held[2, 2] == pytest.approx(-made.stiffness * strain, rel=1e-3)


@pytest.mark.parametrize("F", DEFORMATIONS)
def test_solids_are_the_textbook_ones(F):
    mu, lame, bulk = 1e6 / 2.6, 1e6 * 0.3 / (1.3 * 0.4), 1e6 / 1.2
    J, I1 = np.linalg.det(F), np.trace(F.T @ F)
    logarithmic = mu / 2 * (I1 - 3) - mu * np.log(J) + lame / 2 * np.log(J) ** 2
    split = mu / 2 * (J ** (-2 / 3) * I1 - 3) + bulk / 2 * (J - 1) ** 2
    for made, expected in zip(SOLIDS, (logarithmic, split), strict=True):
        assert number(made.energy(strained(F))) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("made", [*SOLIDS, law("shear", "growing")], ids=lambda made: made.kind)
@pytest.mark.parametrize("F", DEFORMATIONS)
def test_normal_stress_is_that_of_the_cauchy_stress(made, F):
    sigma = solid_stress(made, F) @ F.T / np.linalg.det(F)
    normal = np.linalg.inv(F).T @ [0, 0, 1]
    normal /= np.linalg.norm(normal)
    value = number(normal_stress_of(made.energy, strained(F)))
    assert value == pytest.approx(normal @ sigma @ normal, rel=1e-6, abs=1e-3)


@pytest.mark.parametrize("F", DEFORMATIONS)
def test_energies_and_stretches_do_not_see_a_rotation(F):
    for made in SOLIDS:
        assert number(made.energy(strained(TURN @ F))) == pytest.approx(number(made.energy(strained(F))), rel=1e-10)
    for measure in ("thickness", "volume"):
        one, two = strained(F, measure), strained(TURN @ F, measure)
        for name in ("volume_fraction", "thickness_stretch", "volume_ratio", "area_stretch"):
            assert number(getattr(two, name)) == pytest.approx(number(getattr(one, name)), rel=1e-12)
