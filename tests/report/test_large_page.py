"""The page of results of the paper's full size opens, and is small enough for a mail."""

import pytest
from large_page import write_fields

from ncf_fenicsx.report.page import MOST_BYTES, write_report

pytestmark = [pytest.mark.serial, pytest.mark.slow]


def test_the_page_of_the_full_size_is_below_its_limit(browser, results, tmp_path):
    write_fields(results, tmp_path / "large", 165, 328, 20)  # as many elements in two layers as the paper has in four
    page = write_report(tmp_path / "large")
    assert page.stat().st_size <= MOST_BYTES
    browser.open(page)
    assert browser.complaints() == []
    assert "one cell in place of 2 x 2" in browser.text("#thinned")
    assert browser.run("return document.querySelectorAll('.view canvas').length") == 1
