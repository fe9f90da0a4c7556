"""The page of a fit: its numbers and its tests are tables of their own, all else is said in lines."""

import pytest

from ncf_fenicsx.calibration import page

pytestmark = pytest.mark.serial
WORDS = """compaction exponential: 96 rows

| number (SI) | value | standard error |
|---|---|---|
| compaction.beta2 | 1.5 | 0.004 |

root mean square residual: 0.2 %

| test | in a run | within the noise |
|---|---|---|
| a.csv | 0.2 % | yes |
| b.csv | 0.3 % | no |
"""


def test_numbers_and_tests_are_two_tables(monkeypatch, tmp_path):
    written = []
    monkeypatch.setattr(page, "write_panels", lambda path, title, study: written.append((title, study)) or path)
    page.write_page(tmp_path / "fit.html", "a fabric", WORDS, [])
    ((title, study),) = written
    assert title == "Calibration: a fabric"
    assert study.tables == [
        ("Fitted numbers", ["number (SI)", "value", "standard error"], [["compaction.beta2", "1.5", "0.004"]]),
        ("Tests", ["test", "in a run", "within the noise"], [["a.csv", "0.2 %", "yes"], ["b.csv", "0.3 %", "no"]]),
    ]
    assert study.answer == ["compaction exponential: 96 rows", "root mean square residual: 0.2 %"]
