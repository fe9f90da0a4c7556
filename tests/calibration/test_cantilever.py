"""Bending from the shape of a strip over an edge: the shape of a known table gives it back."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ncf_fenicsx.calibration.cantilever import fit_shape
from ncf_fenicsx.calibration.raw_files import read_tests
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.bending import MomentTable

pytestmark = pytest.mark.serial
WEIGHT, LENGTH = 1.385 * 9.81, 0.22


def hanging(law):
    """Positions and deflections in m of a strip under its weight."""
    bent = np.linspace(0, 40, 40001)
    moment = np.asarray(law.moment_at(bent))

    def slopes(s, state):
        angle, carried = state[:2]
        return [-np.interp(carried, moment, bent), WEIGHT * s * np.cos(angle), -np.cos(angle), np.sin(angle)]

    def shape(tip):
        at = np.linspace(0, LENGTH, 61)
        return solve_ivp(slopes, (0, LENGTH), [tip, 0, 0, 0], t_eval=at, rtol=1e-9, atol=1e-12).y

    tip = brentq(lambda angle: shape(angle)[0, -1], 0.0, 1.5)
    _, _, x, z = shape(tip)
    return x - x[-1], z[-1] - z


def file_of(folder, law, noise, seed):
    x, sunk = hanging(law)
    sunk = sunk + noise * np.random.default_rng(seed).standard_normal(len(sunk))
    rows = [f"{1e3 * a:.5f};{1e3 * b:.5f}" for a, b in sorted(zip(x, sunk, strict=True))]
    path = folder / "strip.csv"
    path.write_text("Position [mm];Deflection [mm]\n" + "\n".join(rows), "utf-8")
    return path


def fitted(folder, law, noise, seed=4):
    """The fit, and the largest relative error of its moments up to the largest curvature of the strip."""
    (raw,) = read_tests(file_of(folder, law, noise, seed))
    fit = fit_shape(raw, {"": {"areal_density": 1.385, "thickness": 1e-3}})
    made = MomentTable.model_validate({k: v for k, v in fit.table.items() if k != "kind"})
    at = np.linspace(0.3, min(0.95 * made.curvature[-1], 5.0), 40)
    return fit, np.abs(made.moment_at(at) / law.moment_at(at) - 1).max()


SOFTENING = {
    "curvature": ["1 1/m", "2 1/m", "3 1/m", "5 1/m", "8 1/m"],
    "moment": ["0.12 N", "0.2 N", "0.25 N", "0.3 N", "0.34 N"],
}


@pytest.mark.parametrize("table", [{}, SOFTENING])
def test_the_shape_of_a_strip_gives_its_table_back(tmp_path, table):
    _, off = fitted(tmp_path, MomentTable.model_validate(table), 0.0)
    assert off < 0.03


def test_noise_of_a_twentieth_of_a_millimetre_leaves_some_percent(tmp_path):
    errors = [fitted(tmp_path, MomentTable(), 5e-5, seed)[1] for seed in range(4)]
    assert np.median(errors) < 0.07
    assert max(errors) < 0.12


def test_a_strip_of_one_stiffness_has_one_piece_with_its_error(tmp_path):
    law = MomentTable.model_validate({"curvature": ["10 1/m"], "moment": ["1.2 N"]})
    fit, off = fitted(tmp_path, law, 2e-4)
    ((name, (curvature, error)),) = fit.values.items()
    moment = float(name.split()[-2])
    assert off < 0.02
    assert abs(moment / 0.12 - curvature) < 3 * error + 0.005 * curvature
    assert error < 0.01 * curvature


def test_it_says_for_which_thickness_the_table_holds(tmp_path):
    fit, _ = fitted(tmp_path, MomentTable(), 0.0)
    assert fit.table["thickness"] == "0.001 m"
    (raw,) = read_tests(file_of(tmp_path, MomentTable(), 0.0, 4))
    with pytest.raises(SceneError, match="no thickness; expected --given thickness="):
        fit_shape(raw, {"": {"areal_density": 1.385}})


def test_without_a_weight_there_is_no_moment(tmp_path):
    (raw,) = read_tests(file_of(tmp_path, MomentTable(), 0.0, 4))
    with pytest.raises(SceneError, match="no areal density; expected --given areal_density="):
        fit_shape(raw, {})
