"""Runs side by side on one page."""

import csv
import io

import pytest
from program import call

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.comparison_page import write_comparison
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial


def test_inputs_that_differ_are_listed(results, other, tmp_path):
    shown = write_comparison([results, other], tmp_path / "both.html").read_text("utf-8")
    table = shown[shown.index("Inputs that differ") : shown.index("The stack in 3-D")]
    assert table.count("<tr>") == 2
    assert "tool.path.0.travel" in table
    same = write_comparison([results, results], tmp_path / "same.html").read_text("utf-8")
    assert "All inputs are the same." in same


def test_curves_lie_over_each_other_and_views_are_linked(browser, results, other, tmp_path):
    browser.open(write_comparison([results, other], tmp_path / "both.html"))
    assert browser.complaints() == []
    assert browser.run("return [...document.querySelectorAll('.view .name')].map((p) => p.textContent)") == [
        "run",
        "copy",
    ]
    text = browser.run("return document.querySelector('figure').curve.csv()")
    rows = list(csv.reader(io.StringIO(text)))
    assert rows[0][1:] == ["run: tool 1, N", "run: supports, N", "copy: tool 1, N", "copy: supports, N"]
    assert len(rows) - 1 == Results.read(results).rows
    canvases = browser.driver.find_elements("css selector", ".view canvas")
    canvases[0].send_keys("\ue014\ue014\ue014")
    browser.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    first, second = browser.run("return [...document.querySelectorAll('.view canvas')].map((c) => c.toDataURL())")
    assert first == second  # the fields are the same, and so is what is seen of them
    assert browser.overflow() <= 0


def test_too_many_runs_are_one_line(results, tmp_path):
    with pytest.raises(SceneError, match="7 folders; expected at most 6"):
        write_comparison([results] * 7, tmp_path / "all.html")


def test_the_command_compares(results, other, tmp_path):
    done = call("report", results, other, "--out", "both.html", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, "page in both.html\n")
    assert (tmp_path / "both.html").is_file()
    for wrong in ([results, other, "--out", "both.pdf"], [results, "--out", "one.html"]):
        refused = call("report", *wrong, folder=tmp_path)
        assert refused.returncode == 2
        assert "expected a file that ends with .html" in refused.stderr
