"""Stretches and volume fractions of a deformation."""

import numpy as np
import pytest
import ufl
from laws_by_number import DEFORMATIONS, VF0, strained

from ncf_fenicsx.laws.kinematics import Kinematics
from ncf_fenicsx.laws.law import number

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("F", DEFORMATIONS)
def test_volume_fraction_by_thickness_and_by_volume(F):
    by_thickness, by_volume = (number(strained(F, measure).volume_fraction) for measure in ("thickness", "volume"))
    assert by_volume == pytest.approx(VF0 / np.linalg.det(F), rel=1e-12)
    area = np.sqrt(np.linalg.det((F.T @ F)[:2, :2]))
    assert by_thickness == pytest.approx(VF0 * area / np.linalg.det(F), rel=1e-12)
    stretch = number(strained(F).thickness_stretch)
    assert by_thickness == pytest.approx(VF0 * np.exp(-np.log(stretch)), rel=1e-12)  # Eq. 5 of the paper


def test_an_inverted_body_has_a_negative_stretch():
    assert number(Kinematics(ufl.as_matrix(np.diag([1.0, 1.0, -0.2]).tolist())).thickness_stretch) < 0
