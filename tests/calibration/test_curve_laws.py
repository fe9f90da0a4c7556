"""Permeability along and across the fibres: the law that made the data comes back."""

import numpy as np
import pytest

from ncf_fenicsx.calibration.curve_laws import fit_curve
from ncf_fenicsx.calibration.raw_files import read_tests
from ncf_fenicsx.laws.permeability import Gebart, KozenyCarman

pytestmark = pytest.mark.serial
VF = np.linspace(0.45, 0.6, 8)


def raw_tests(folder, **columns):
    """Tests of a file with these columns over Vf."""
    headings = {"along": "Permeability [m2]", "across": "Through-thickness permeability [m2]"}
    lines = [";".join(["Vf [-]", *(headings[name] for name in columns)])]
    lines += [";".join(f"{value:.8e}" for value in row) for row in zip(VF, *columns.values(), strict=True)]
    path = folder / f"{'_'.join(columns)}.csv"
    path.write_text("\n".join(lines), "utf-8")
    return read_tests(path)


def test_both_directions_of_one_file_give_both_constants(tmp_path):
    law = KozenyCarman(constant_along=0.7, constant_across=9.0)
    found = fit_curve("permeability", raw_tests(tmp_path, along=law.along(VF), across=law.across(VF)), None, {})
    assert [curve.y_name for curve in found] == ["permeability", "permeability_across"]
    for curve in found:
        assert curve.table["constant_along"] == pytest.approx(0.7, rel=1e-4)
        assert curve.table["constant_across"] == pytest.approx(9.0, rel=1e-4)
        assert curve.model == pytest.approx(curve.y, rel=1e-4)


def test_two_files_give_one_law(tmp_path):
    law = Gebart(fibre_radius="4 um")
    both = raw_tests(tmp_path, along=law.along(VF)) + raw_tests(tmp_path, across=law.across(VF))
    along, across = fit_curve("permeability", both, "gebart", {})
    assert along.values == across.values
    assert along.values["fibre_radius"][0] == pytest.approx(4e-6, rel=1e-4)
    assert len(along.x) == len(across.x) == len(VF)


def test_a_direction_that_was_not_measured_is_left_as_it_is(tmp_path):
    usual = KozenyCarman()
    (found,) = fit_curve("permeability", raw_tests(tmp_path, across=3 * usual.across(VF)), None, {})
    assert set(found.values) == {"constant_across"}
    assert found.table["constant_along"] == usual.constant_along
    assert found.values["constant_across"][0] == pytest.approx(usual.constant_across / 3, rel=1e-4)
