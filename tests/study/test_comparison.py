"""Histories held against each other: known differences found, units converted, mistakes named."""

import csv
import re
import subprocess
import sys

import numpy as np
import pytest
from program import DEMOS, call

from ncf_fenicsx import Scene, run
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.study.comparison import Comparison, Curves, unit_of

pytestmark = pytest.mark.serial


def written(path, columns):
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return Curves.read(path)


def ramp(path, count=11, factor=1.0, **more):
    time = np.linspace(0, 2, count)
    return written(path, {"time": time, "tool_force": factor * time**2} | more)


def test_a_difference_is_found_where_it_is(folder):
    time = np.linspace(0, 2, 11)
    bump = time**2 + 0.08 * np.sin(np.pi * time / 2) ** 2  # 2 % of the largest, half-way
    comparison = Comparison(
        written(folder / "a.csv", {"time": time, "tool_force": bump}), ramp(folder / "b.csv", 2001), None
    )
    (found,) = comparison.differences
    assert (found.column, found.largest) == ("tool_force", pytest.approx(4))
    assert found.worst == pytest.approx(0.02, rel=1e-4)
    assert found.where == pytest.approx(1)
    assert found.mean_square == pytest.approx(0.02 * np.sqrt(3 / 8), rel=1e-3)
    assert found.last == pytest.approx(0, abs=1e-9)
    assert not comparison.within(0.0199)
    assert comparison.within(0.0201)
    assert comparison.cautions == []


def test_units_of_another_code_are_converted(folder):
    ours = ramp(folder / "ours.csv")
    milliseconds = 1e3 * ours.columns["time"]
    theirs = written(
        folder / "theirs.csv",
        {"time [ms]": milliseconds, "tool_force[kN]": 1e-3 * ours.columns["tool_force"], "kinetic": 0 * milliseconds},
    )
    assert list(theirs.columns) == ["time", "tool_force"]
    assert Comparison(theirs, ours, None).differences[0].worst < 1e-14


def test_only_what_both_cover_is_compared_and_said(folder):
    short = written(folder / "short.csv", {"time": [0, 0.5, 1], "tool_force": [0, 0.25, 1]})
    comparison = Comparison(short, ramp(folder / "long.csv", 2001), None)
    assert comparison.differences[0].worst < 1e-6
    assert comparison.cautions == [f"{folder / 'long.csv'}: only 0 to 1 of its time is compared"]
    assert "straight over 50 %" in Comparison(ramp(folder / "fine.csv", 2001), short, None).cautions[0]


def test_another_abscissa_and_gaps_in_columns(folder):
    time = np.linspace(0, 1, 5)
    ours = written(folder / "a.csv", {"time": time, "tool_displacement": time**2, "tool_force": 3 * time**2})
    holes = ["0", "", "1.5", "", "3"]
    theirs = written(folder / "b.csv", {"tool_displacement": [0, 0.2, 0.5, 0.7, 1], "tool_force": holes})
    (found,) = Comparison(ours, theirs, ["tool_force"], "tool_displacement").differences
    assert found.worst < 1e-15


def test_a_reference_of_zero_is_no_division(folder):
    zero = written(folder / "zero.csv", {"time": [0, 1], "gap_max_1": [0, 0]})
    open_ = written(folder / "open.csv", {"time": [0, 1], "gap_max_1": [0, 1e-5]})
    assert Comparison(zero, zero, None).within(0)
    assert not Comparison(open_, zero, None).within(1e9)
    assert "not in the reference" in Comparison(open_, zero, None).table(0.1)


@pytest.mark.parametrize(
    ("column", "unit"),
    [
        ("tool_force_2", "N"),
        ("mould_pressure_max", "Pa"),
        ("gap_max_3", "m"),
        ("vf_mean_layer_2", "1"),
        ("force", None),
    ],
)
def test_units_of_all_columns_are_known(column, unit):
    assert unit_of(column) == unit


MISTAKES = {
    "time,tool_force [mm]\n0,0\n1,1\n": "column tool_force in 'mm'; expected a unit of N",
    "time,tool_force [potatoes]\n0,0\n1,1\n": "expected a unit of N",
    "time,tool_force\n0,0\n1,many\n": "tool_force = 'many'; expected a number",
    "time,tool_force\n0,0\n": "1 rows; expected a heading and two rows or more",
    "": "0 rows; expected a heading",
    "time,time\n0,0\n1,1\n": "column time is there twice",
    "time,tool_force\n1,0\n0,1\n": "time goes back",
    "time,force\n0,0\n1,1\n": "share no column of force, Vf or gaps",
    "tool_force\n0\n1\n": "no column time; expected one of tool_force",
    "time,tool_force\n5,0\n6,1\n": "expected rows of the first within the second",
}


@pytest.mark.parametrize("text", MISTAKES)
def test_a_mistake_is_named(text, folder):
    (folder / "theirs.csv").write_text(text)
    with pytest.raises(SceneError, match=re.escape(MISTAKES[text])):
        Comparison(ramp(folder / "ours.csv"), Curves.read(folder / "theirs.csv"), None)


def test_the_command_ends_with_the_verdict(folder):
    ramp(folder / "a.csv", factor=1.01)
    ramp(folder / "b.csv")
    held = call("compare", "a.csv", "b.csv", "--picture", "both.png", folder=folder)
    assert held.returncode == 0, held.stderr
    assert "| tool_force | 4 N | 1 % | 2 |" in held.stdout
    assert (folder / "both.png").stat().st_size > 10_000
    assert call("compare", "a.csv", "b.csv", "--tolerance", "0.005", folder=folder).returncode == 1
    missing = call("compare", "a.csv", "none.csv", folder=folder)
    assert (missing.returncode, missing.stdout) == (2, "")
    assert missing.stderr.startswith("ncf-fenicsx: none.csv: No such file")
    assert call("compare", "a.csv", "b.csv", "--picture", "no/where.png", folder=folder).returncode == 2


def test_the_example_of_another_code_agrees_with_a_run(folder):
    """The paper's law from its numbers alone, in units of its own, against one hexahedron under a plate."""
    subprocess.run([sys.executable, DEMOS / "verification" / "closed_form.py", folder / "again.csv"], check=True)
    assert (folder / "again.csv").read_bytes() == (DEMOS / "verification" / "closed_form.csv").read_bytes()
    result = run(
        Scene.read(DEMOS / "single_element.toml", ["output.picture=false", "output.report=false"]), folder / "run"
    )
    ours, theirs = Curves.read(result.folder / "history.csv"), Curves.read(DEMOS / "verification" / "closed_form.csv")
    assert Comparison(ours, theirs, ["tool_force"], "vf_max").within(1e-4)
