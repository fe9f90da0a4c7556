"""Pages of studies at many points: effects, interactions, indices, distributions, all runs across parallel axes."""

import csv
import json

import numpy as np
import pytest

from ncf_fenicsx.report.study_page import is_study, write_study
from ncf_fenicsx.report.sweep_panels import MOST_LINES, parallel, sweep_panels
from ncf_fenicsx.sweeps.estimates import Estimate
from ncf_fenicsx.sweeps.findings import distribution_panels, effect_panels, estimate_panels, write_findings
from ncf_fenicsx.sweeps.inputs import Column, Input
from ncf_fenicsx.sweeps.outcomes import FORCE, VF
from ncf_fenicsx.sweeps.samples import Samples

pytestmark = pytest.mark.serial
RADIUS = Input((Column("tool.radius", "m"),), (("0.002",), ("0.004",)), logarithmic=True)
KIND = Input((Column("laws.rate.kind"),), (("kelly",), ("none <b>",)))
HEADINGS = ["tool.radius [m]", "laws.rate.kind"]


def swept(radius, kind, force, run, ending="done"):
    cells = [radius, kind, run, force, "0.5" if force else "", "3.5", ending, "" if force else "why, \n it stopped"]
    names = [*HEADINGS, "run", "force [N]", "vf_max", "seconds [s]", "ending", "reason"]
    return dict(zip(names, cells, strict=True))


ROWS = [
    swept("0.002", "kelly", "1.0", "a"),
    swept("0.004", "kelly", "2.0", "b"),
    swept("0.002", "none <b>", "3.0", "c"),
    swept("0.004", "none <b>", "6.0", "d"),
    swept("0.004", "none <b>", "", "e", "stopped"),
]


@pytest.fixture
def folder(tmp_path):
    with (tmp_path / "rows.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(ROWS[0]))
        writer.writeheader()
        writer.writerows(ROWS)
    return tmp_path


def samples(folder):
    return Samples.read(folder / "rows.csv", HEADINGS, [FORCE.heading, VF.heading])


def panels_of(folder, found):
    """Panels from what is written, as the page reads it."""
    write_findings(folder, ["all is well"], found)
    return sweep_panels(ROWS, json.loads((folder / "findings.json").read_text("utf-8"))["panels"])


def by_label(panel):
    return {line["label"]: [list(point) for point in line["points"]] for line in panel["lines"]}


def test_runs_alone_where_a_study_has_not_ended(folder):
    force, _, _ = sweep_panels(ROWS, [])
    assert (force["title"], force["group"]) == ("force [N] over tool.radius [m]", "force [N]")
    assert by_label(force) == {"run": [[0.002, 1.0, "a"], [0.002, 3.0, "c"], [0.004, 2.0, "b"], [0.004, 6.0, "d"]]}
    with (folder / "rows.csv").open("a", encoding="utf-8") as file:
        file.write("0.002,kel")  # a row that is just being written
    shown = write_study(folder).read_text("utf-8")
    assert "not ended" in shown
    assert "<td>kel</td>" not in shown


def test_effects_have_runs_means_and_shares(folder):
    radius, kind, _ = panels_of(folder, effect_panels([RADIUS, KIND], samples(folder), [FORCE]))
    assert by_label(radius)["mean"] == [[0.002, 2.0, ""], [0.004, 4.0, ""]]
    assert radius["logarithmic"] == "x"
    assert radius["title"].startswith("tool.radius: 29 % of the variance of the largest force")
    assert kind["names"] == ["kelly", "none <b>"]
    assert by_label(kind)["mean"] == [[1.0, 1.5, ""], [2.0, 4.5, ""]]
    assert [1.0, 2.0, "b"] in by_label(kind)["run"]


def test_interactions_have_a_line_for_each_level_of_the_other_input(folder):
    *_, both = panels_of(folder, effect_panels([RADIUS, KIND], samples(folder), [FORCE]))
    assert by_label(both) == {
        "laws.rate.kind kelly": [[0.002, 1.0, ""], [0.004, 2.0, ""]],
        "laws.rate.kind none <b>": [[0.002, 3.0, ""], [0.004, 6.0, ""]],
    }


def test_numbers_have_their_intervals_beside_each_other(folder):
    estimates = [
        {"first": Estimate(0.5, 0.4, 0.6), "total": Estimate(0.7)},
        {"first": Estimate(0.2), "total": Estimate(0.3)},
    ]
    (panel,) = panels_of(folder, estimate_panels([RADIUS, KIND], {FORCE: estimates}))
    assert panel["names"] == ["tool.radius", "laws.rate.kind"]
    assert by_label(panel)["first"] == [[0.875, 0.5, "tool.radius", 0.4, 0.6], [1.875, 0.2, "laws.rate.kind"]]
    assert panel["y"] == "share of the variance"


def test_a_distribution_has_its_density_and_its_marks(folder):
    values = np.random.default_rng(0).normal(5.0, 1.0, 4000)
    (panel,) = panels_of(folder, distribution_panels({FORCE: values}, {FORCE: {"5 %": Estimate(3.4)}}, ["5 %"]))
    x, y = np.array([point[:2] for point in by_label(panel)["density"]]).T
    assert np.trapezoid(y, x) == pytest.approx(1.0)
    assert by_label(panel)["5 %"] == [[3.4, 0.0, ""], [3.4, y.max(), ""]]


def test_all_runs_that_are_done_are_lines_across_axes():
    found = parallel(ROWS)
    assert [axis["heading"] for axis in found["axes"]] == [*HEADINGS, "force [N]", "vf_max", "seconds [s]"]
    assert found["axes"][1] == {"heading": "laws.rate.kind", "words": ["kelly", "none <b>"], "values": [0, 0, 1, 1]}
    assert found["runs"] == ["a", "b", "c", "d"]
    assert found["axes"][found["coloured"]]["heading"] == "force [N]"
    many = parallel([swept("0.002", "kelly", "1.0", str(number)) for number in range(5000)])
    assert (len(many["runs"]), many["of"]) == (MOST_LINES, 5000)


def test_the_page_opens_and_shows_one_result_at_a_time(browser, folder):
    assert is_study(folder)
    write_findings(
        folder, ["of the variance carries <b> all"], effect_panels([RADIUS, KIND], samples(folder), [FORCE, VF])
    )
    browser.open(folder / "report.html")
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.overflow() <= 0
    assert "of the variance carries <b> all" in browser.text("main")
    shown = (
        "return [...document.querySelectorAll('figure')].filter((f) => f.offsetHeight).map((f) => f.curve.content.y)"
    )
    assert browser.run(shown) == 3 * ["largest force on the tool (N)"]
    browser.change("group", "largest Vf", "change")
    assert browser.run(shown) == 3 * ["largest Vf"]
    assert browser.run("return document.querySelectorAll('#parallel polyline').length") == 4
    browser.run("document.querySelector('#parallel polyline').dispatchEvent(new PointerEvent('pointerenter'))")
    assert browser.text("#shown-run") == (
        "a: tool.radius [m] 0.002, laws.rate.kind kelly, force [N] 1, vf_max 0.5, seconds [s] 3.5"
    )
    read = []
    for key in ("ArrowDown", "ArrowDown", "ArrowUp"):
        browser.run(
            f"document.querySelector('#parallel .scroll').dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}'}}))"
        )
        read.append(browser.text("#shown-run")[:2])
    assert read == ["b:", "c:", "b:"]
    assert browser.run("return document.querySelectorAll('#parallel .shown').length") == 1
    table = browser.run("return document.querySelector('figure').curve.csv()")
    assert len(table.splitlines()) == 1 + 4  # runs at one place are not one point
    assert browser.run("return document.querySelectorAll('b').length") == 0
