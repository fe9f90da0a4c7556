"""The page of a sequence of runs: value and bar of each quantity over the cost of its levels, and the answer."""

import json

import pytest

from ncf_fenicsx import SceneError
from ncf_fenicsx.report.sequence_panels import level_rows, sequence_panels
from ncf_fenicsx.report.study_page import is_study, write_study

pytestmark = pytest.mark.serial


def quantity(title, value, unit="", factor=1.0, limit=None):
    known = {"value": value, "bar": 0.01 * value, "relative_bar": 0.01, "order": None, "limit": limit, "levels": 3}
    words = {"title": title, "words": f"{value} +- 1 %", "bar_words": "+- 1 %", "unit": unit, "factor_to_unit": factor}
    return known | words | {"basis": "observed order"}


def level(number, seconds, force, bar, field):
    values = {"force": force, "void_volume": 2e-9}
    cost = {"level": number, "unknowns": 100 * 4**number, "seconds": seconds, "peak_memory_mb": 300.2}
    bars = {"force": bar, "void_volume": bar and 1e-10, "vf_field": field}
    return cost | {"values": values, "bars": bars, "stability_lost_at": None if number else 2.5}


ANSWER = {
    "asked": {"quantities": ["force", "void_volume", "vf_field"], "tolerance": 0.02},
    "met": True,
    "ending": "all error bars are inside 2 %",
    "quantities": {
        "force": quantity("largest force", 4.0, "N", limit=4.1),
        "void_volume": quantity("largest volume of voids", 2e-9, "mm3", 1e9),
        "vf_field": quantity("field of Vf", 0.1),
    },
    "words": ["largest force: 4 N +- 1 %", "stability is lost <b>at once"],
    "different_branches": False,
    "levels": [level(0, 1.0, 3.0, None, None), level(1, 4.0, 3.8, 2.4, 0.02), level(2, 16.0, 4.0, 0.2, 0.001)],
}


def test_a_panel_for_each_quantity_over_cost():
    force, voids, field = sequence_panels(ANSWER)
    levels, asked, limit = (line["points"] for line in force["lines"])
    assert levels == [
        (1.0, 3.0, "level 0"),
        (4.0, 3.8, "level 1", pytest.approx(1.4), pytest.approx(6.2)),
        (16.0, 4.0, "level 2", 3.8, 4.2),
    ]
    assert asked == [(1.0, 4.0, "", 3.92, 4.08), (16.0, 4.0, "", 3.92, 4.08)]
    assert [point[1] for point in limit] == [4.1, 4.1]
    assert voids["lines"][0]["points"][2][3:] == (pytest.approx(1.9), pytest.approx(2.1))
    assert len(voids["lines"]) == 2  # values tend to no known limit
    assert [point[:2] for point in field["lines"][0]["points"]] == [(4.0, 20.0), (16.0, 1.0)]


def test_levels_are_a_table():
    head, rows = level_rows(ANSWER)
    assert head[-3:] == ["largest force (N)", "largest volume of voids (mm3)", "field of Vf"]
    assert rows[0] == ["0", "100", "1", "300", "2.5", "3 without a bar yet", "2 without a bar yet", "without a bar yet"]
    assert rows[2][4:] == ["never", "4 +- 0.2", "2 +- 0.1", "+- 0.001"]


def test_the_page_opens(browser, tmp_path):
    (tmp_path / "accuracy.json").write_text(json.dumps(ANSWER), encoding="utf-8")
    assert is_study(tmp_path)
    browser.open(write_study(tmp_path))
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.overflow() <= 0
    text = browser.text("main")
    for words in ("The tolerance is met: all error bars are inside 2 %.", "stability is lost <b>at once", "level_2"):
        assert words in text
    assert browser.run("return document.querySelectorAll('figure').length") == 3
    svg = browser.run("return document.querySelector('figure').curve.svg()")
    assert svg.count("<path") == 2
    assert svg.count("<polygon") == 1


def test_a_sequence_that_has_only_begun_has_a_page(tmp_path):
    one = ANSWER | {
        "levels": ANSWER["levels"][:1],
        "quantities": {"force": ANSWER["quantities"]["force"] | {"bar": None}},
    }
    (tmp_path / "accuracy.json").write_text(json.dumps(one | {"met": False, "ending": "goes on"}), encoding="utf-8")
    assert "The tolerance is not met: goes on." in write_study(tmp_path).read_text("utf-8")
    (tmp_path / "accuracy.json").write_text("{}", encoding="utf-8")
    with pytest.raises(SceneError, match=r"accuracy\.json: cannot be read"):
        write_study(tmp_path)
