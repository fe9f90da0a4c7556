"""Curves have a band or a bar only where a column, or a sequence of runs, has told one."""

import csv
import io
import json

import numpy as np
import pytest

from ncf_fenicsx.report.curves import curves
from ncf_fenicsx.report.page import write_report
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial
BAR = {"value": 1.0, "bar": 0.25, "bar_words": "+- 5 % (0.25 N), 3 levels, observed order 1"}


@pytest.fixture
def finest(copied):
    """Results of a run that was the finest of a sequence."""
    record = json.loads((copied / "run.json").read_text("utf-8"))
    known = {"force": BAR, "vf": BAR | {"bar": None}, "vf_field": BAR, "void_volume": BAR, "wrinkle_height": BAR}
    (copied / "run.json").write_text(json.dumps(record | {"accuracy": {"quantities": known}}), encoding="utf-8")
    return copied


def by_title(folder):
    return {curve["title"]: curve for curve in curves(Results.read(folder))}


def test_without_an_error_of_its_own_a_curve_says_so(results):
    found = by_title(results)
    for title in ("Force", "Vf in the stack"):
        assert found[title]["note"].startswith("No error band: ")
        assert not {"bands", "bar"} & set(found[title])
    assert found["Work"]["bands"] == {"tool_work": "tool_work_error"}
    assert [line["column"] for line in found["Work"]["lines"]] == ["tool_work"]


def test_a_sequence_has_bars_at_the_largest_values(finest):
    found, history = by_title(finest), Results.read(finest).history
    assert found["Force"]["bar"] == {
        "column": "tool_force",
        "row": int(np.argmax(history["tool_force"])),
        "half": 0.25,
    }
    assert found["Force"]["note"] == f"The bar at the largest value: {BAR['bar_words']}."
    assert found["Vf in the stack"]["note"].startswith("No error band: ")  # no bar yet
    assert {title for title, curve in found.items() if "bar" in curve} == {
        "Force",
        "Volume of the voids",
        "Height of wrinkles",
    }


@pytest.fixture
def banded(finest):
    """The same with an error at each step, a hundredth of each force."""
    history = Results.read(finest).history
    errors = np.column_stack([history["time"], history["tool_force"] / 100])
    np.savetxt(finest / "error_bands.csv", errors, "%.17g", ",", header="time,tool_force_error", comments="")
    return finest


def test_a_sequence_has_a_band_around_a_curve_whose_errors_it_knows(banded):
    found = by_title(banded)
    assert found["Force"]["bands"] == {"tool_force": "tool_force_error"}
    assert "bar" not in found["Force"]
    for words in ("The band is tool_force_error on both sides. ", BAR["bar_words"]):
        assert words in found["Force"]["note"]
    assert found["Vf in the stack"]["note"].startswith("No error band: ")


def test_bands_of_a_run_that_has_gone_on_since_are_not_those_of_its_history(banded):
    with (banded / "history.csv").open("a") as file:
        file.write((banded / "history.csv").read_text().splitlines()[-1] + "\n")
    assert by_title(banded)["Force"]["bar"]["half"] == 0.25


def rows_of(browser, title, call="csv()"):
    script = (
        "return [...document.querySelectorAll('figure')].find((f) => f.curve.content.title === arguments[0]).curve."
    )
    return browser.run(script + call, title)


def test_bars_and_bands_are_drawn(browser, finest):
    write_report(finest)
    browser.open(finest / "report.html")
    assert browser.complaints() == []
    history = Results.read(finest).history
    force = list(csv.DictReader(io.StringIO(rows_of(browser, "Force"))))
    ends = {end: [row[f"tool 1, {end} end, N"] for row in force] for end in ("lower", "upper")}
    row = int(np.argmax(history["tool_force"]))
    for end, sign in (("lower", -1), ("upper", 1)):
        assert float(ends[end][row]) == pytest.approx(history["tool_force"][row] + sign * 0.25)
        assert sum(text != "" for text in ends[end]) == 1
    work = list(csv.DictReader(io.StringIO(rows_of(browser, "Work"))))
    for number, one in enumerate(work):
        high, low = (float(one[f"of the tools, {end} end, J"]) for end in ("upper", "lower"))
        assert high - low == pytest.approx(2 * history["tool_work_error"][number], abs=1e-15)
    assert "polygon" in rows_of(browser, "Work", "svg()")
    assert rows_of(browser, "Force", "svg()").count("<path") == 1
    scale = rows_of(browser, "Force", "drawn.scales.y.max")
    assert scale >= history["tool_force"][row] + 0.25


def test_a_band_is_drawn_around_the_force(browser, banded):
    write_report(banded)
    browser.open(banded / "report.html")
    assert browser.complaints() == []
    for row in csv.DictReader(io.StringIO(rows_of(browser, "Force"))):
        low, force, high = (float(row[f"tool 1{end}, N"]) for end in (", lower end", "", ", upper end"))
        assert (low, high) == pytest.approx((0.99 * force, 1.01 * force))
    assert "polygon" in rows_of(browser, "Force", "svg()")
