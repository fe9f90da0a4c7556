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


def file_of(folder, noise):
    x, sunk = hanging(MomentTable())
    sunk = sunk + noise * np.random.default_rng(4).standard_normal(len(sunk))
    rows = [f"{1e3 * a:.5f};{1e3 * b:.5f}" for a, b in sorted(zip(x, sunk, strict=True))]
    path = folder / "strip.csv"
    path.write_text("Position [mm];Deflection [mm]\n" + "\n".join(rows), "utf-8")
    return path


@pytest.mark.parametrize(("noise", "within"), [(0.0, 0.13), (5e-5, 0.13)])
def test_the_shape_of_a_strip_gives_its_table_back(tmp_path, noise, within):
    (raw,) = read_tests(file_of(tmp_path, noise))
    fit = fit_shape(raw, {"": {"areal_density": 1.385}})
    made, true = MomentTable.model_validate({k: v for k, v in fit.table.items() if k != "kind"}), MomentTable()
    at = np.linspace(0.8, 4.0, 30)
    assert made.moment_at(at) == pytest.approx(true.moment_at(at), rel=within)


def test_without_a_weight_there_is_no_moment(tmp_path):
    (raw,) = read_tests(file_of(tmp_path, 0.0))
    with pytest.raises(SceneError, match="no areal density; expected --given areal_density="):
        fit_shape(raw, {})
