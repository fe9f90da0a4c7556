"""Pages of studies: one panel a question, the best front, points that tell their names."""

import csv

import pytest

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.study_page import is_study, write_study
from ncf_fenicsx.report.study_panels import error_panels, stability_panels

pytestmark = pytest.mark.serial
ROWS = [
    {"method": "mesh", "level": "8", "seconds": "1", "force_error": "0.1", "vf_max_error": "0.2", "void_error": ""},
    {"method": "mesh", "level": "16", "seconds": "4", "force_error": "0.02", "vf_max_error": "0.1", "void_error": ""},
    {
        "method": "steps <b>",
        "level": "2",
        "seconds": "2",
        "force_error": "0.2",
        "vf_max_error": "0.1",
        "void_error": "",
    },
    {"method": "steps <b>", "level": "4", "seconds": "3", "force_error": "0", "vf_max_error": "", "void_error": ""},
]
PUSHED = [
    {"axis": "depth", "value": "1 mm", "ending": "done", "force_N": "2.5"},
    {"axis": "depth", "value": "9 mm", "ending": "stopped", "force_N": ""},
    {"axis": "speed", "value": "fast", "ending": "done", "force_N": "3"},
]


@pytest.fixture
def study(tmp_path):
    with (tmp_path / "error_time.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(ROWS[0]))
        writer.writeheader()
        writer.writerows(ROWS)
    return tmp_path


def test_a_panel_for_each_error_with_its_front():
    force, vf = error_panels(ROWS)
    assert force["title"] == "Error of the largest force"
    assert vf["title"] == "Error of the largest Vf"
    assert [line["label"] for line in force["lines"]] == ["mesh", "steps <b>", "best front"]
    front = force["lines"][-1]["points"]
    assert [x for x, _, _ in front] == [1.0, 3.0]  # the error of 0 is drawn, above zero
    assert front[-1][1] > 0
    assert len(vf["lines"][1]["points"]) == 1


def test_a_panel_for_each_axis_of_stability():
    depth, speed = stability_panels(PUSHED)
    assert [(line["label"], line["points"]) for line in depth["lines"]] == [
        ("done", [(1, 2.5, "1 mm")]),
        ("stopped early", [(2, 0.0, "9 mm")]),
    ]
    assert speed["title"] == "speed"


def test_page_of_a_study_opens(browser, study):
    assert is_study(study)
    browser.open(write_study(study))
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.overflow() <= 0
    assert browser.run("return document.querySelectorAll('figure').length") == 2
    assert browser.run("return document.querySelectorAll('b').length") == 0
    assert "steps <b>" in browser.text("main")
    table = browser.run("return document.querySelector('figure').curve.csv()").splitlines()
    assert table[0].split(",")[0] == '"run time in s'
    browser.run(
        "const over = document.querySelector('figure .u-over'), box = over.getBoundingClientRect();"
        "for (const type of ['mouseenter', 'mousemove', 'pointermove'])"
        "  over.dispatchEvent(new MouseEvent(type, {clientX: box.left + 5, clientY: box.top + 5, bubbles: true}));"
    )
    browser.wait("return document.querySelector('figure .point').textContent.startsWith('mesh 8')")


def test_a_broken_table_is_one_line(study):
    (study / "error_time.csv").write_text("method,level\nmesh,8\n", encoding="utf-8")
    assert is_study(study)
    write_study(study)
    (study / "error_time.csv").write_text("method,force_error,seconds,level\nmesh,0.1,slow,8\n", encoding="utf-8")
    with pytest.raises(SceneError, match=r"error_time\.csv: cannot be read"):
        write_study(study)
