"""Waves of a sheet with shear on an elastic foundation: their length, and what `check` says of elements and laws."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.mesh.wave_resolution import least_shear_modulus, natural_wavelength

pytestmark = pytest.mark.serial


def scene(shear="10 MPa", bending=None, element=1.0):
    laws = {"shear": {"modulus": shear}} | ({} if bending is None else {"bending": bending})
    tool = {"width": "infinite", "path": [{"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}]}
    stack = {"layers": 2, "size": ["60 mm", "2 mm"], "divisions": [round(60 / element), 1], "grading": [0, 0]}
    return Scene.from_table({"stack": stack, "laws": laws, "tool": tool})


@pytest.mark.parametrize("shear", [5e6, 10e6, 1e9])
def test_the_length_is_that_of_the_least_force(shear):
    """A sheet with shear needs the force B q^2 / (1 + B q^2 / S) + k / q^2 for waves of number q."""
    case = scene(f"{shear} Pa", {"modulus": "10 MPa", "poisson": 0.0})
    rigidity, stiffness, shear_stiffness = 10e6 * 2e-3**3 / 12, case.natural_stiffness, shear * 2e-3

    def force(length):
        square = (2 * np.pi / length) ** 2
        return rigidity * square / (1 + rigidity * square / shear_stiffness) + stiffness / square

    least = minimize_scalar(force, bounds=(1e-3, 50e-3), method="bounded", options={"xatol": 1e-9})
    assert natural_wavelength(case) == pytest.approx(least.x, rel=1e-3)


def test_below_a_shear_modulus_no_length_is_the_best():
    bending = {"modulus": "10 MPa"}
    modulus = least_shear_modulus(scene(bending=bending))
    assert natural_wavelength(scene(f"{0.99 * modulus} Pa", bending)) is None
    assert natural_wavelength(scene(f"{1.01 * modulus} Pa", bending)) < natural_wavelength(scene(bending=bending))


def test_check_says_which_element_would_do():
    bending = {"modulus": "10 MPa"}
    needed = 1e3 * natural_wavelength(scene(bending=bending)) / (4 * np.pi)
    fine = 60 / np.ceil(60 / needed)
    assert not [words for words in size_of(scene(bending=bending, element=fine)).cautions if "waves" in words]
    (words,) = [words for words in size_of(scene(bending=bending, element=3.0)).cautions if "waves" in words]
    assert f"ask for elements of {needed:.2g} mm; under tools they are up to 3 mm along x" in words


def test_a_measured_table_bends_by_its_first_slope():
    table = {"kind": "table", "curvature": ["-1 1/m", "2 1/m", "5 1/m"], "moment": ["-0.3 N", "0.1 N", "0.2 N"]}
    same = {"modulus": "75 MPa", "poisson": 0.0}
    assert natural_wavelength(scene("1 GPa", table)) == pytest.approx(natural_wavelength(scene("1 GPa", same)))


@pytest.mark.parametrize(("bending", "word"), [(None, "laws.bending: not given"), ({"modulus": "1 GPa"}, "laws.shear")])
def test_waves_without_a_length_are_told(bending, word):
    assert any(words.startswith(word) for words in size_of(scene("0.1 MPa", bending)).cautions)
