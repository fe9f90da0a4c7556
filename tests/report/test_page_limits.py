"""The page in a browser where something is missing or too large: it says so, and shows what there is."""

import base64
import re
import shutil

import meshio
import pytest
from browser import PAGE, all_readings, opened, step_of

from ncf_fenicsx.report.page import write_report
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial


def test_a_page_without_webgl_shows_the_picture(results):
    with opened("--disable-gpu", "--disable-3d-apis") as browser:
        browser.open(results / PAGE)
        assert "no WebGL 2" in browser.text("#no-view")
        assert browser.run("return document.querySelector('#fallback img').clientWidth") > 300
        assert browser.run("return document.getElementById('view').hidden")
        assert browser.run("return document.querySelectorAll('figure').length") > 5


def test_print_is_two_pages(browser, results):
    browser.open(results / PAGE)
    data = base64.b64decode(browser.command("Page.printToPDF", preferCSSPageSize=True)["data"])
    assert len(re.findall(rb"/Type\s*/Page\b", data)) == 2


def test_a_page_without_fields_has_its_curves(browser, copied):
    (copied / "fields.pvd").unlink()
    shutil.rmtree(copied / "fields")
    write_report(copied)
    browser.open(copied / PAGE)
    assert "no fields to draw" in browser.text("#no-view")
    assert browser.complaints() == []
    assert "Force" in browser.text("#curves")


def test_a_view_that_takes_too_much_room_says_so(browser, copied, monkeypatch):
    from ncf_fenicsx.report import page as pages

    monkeypatch.setattr(pages, "spare", lambda _: 2000)
    write_report(copied)
    browser.open(copied / PAGE)
    assert "take too much room for a page: 24 cells" in browser.text("#no-view")
    assert browser.complaints() == []


def test_cells_that_became_one_are_told(browser, copied, monkeypatch):
    from ncf_fenicsx.report import decimation, model
    from ncf_fenicsx.report import page as pages

    monkeypatch.setattr(decimation, "FEWEST", 2)
    monkeypatch.setattr(model, "FEW_STEPS", 1000)
    monkeypatch.setattr(pages, "MOST_BYTES", write_report(copied).stat().st_size - 3000)
    write_report(copied)
    browser.open(copied / PAGE)
    assert browser.complaints() == []
    words = "one cell in place of 2 x 2, with their mean, and the nodes at its corners"
    assert browser.text("#thinned") == f"To keep the page small the view has {words}."
    browser.change("field", "displacement_z", "change")
    mesh = meshio.read(copied / Results.read(copied).snapshots[-1][1])
    found = all_readings(browser)
    assert len(found) > 5
    for node, value in found.items():
        assert value == pytest.approx(1e3 * mesh.point_data["displacement"][node, 2], abs=1.1 * step_of(browser) + 1e-6)
    browser.change("field", "volume_fraction", "change")
    browser.driver.find_element("css selector", ".view canvas").send_keys("\ue007")
    assert "mean of 2 x 2 cells" in browser.text(".view .read")


def test_thinned_steps_are_told(browser, copied, monkeypatch):
    from ncf_fenicsx.report import page as pages

    most = write_report(copied).stat().st_size - 3000
    monkeypatch.setattr(pages, "MOST_BYTES", most)
    assert write_report(copied).stat().st_size <= most
    browser.open(copied / PAGE)
    steps = len(Results.read(copied).snapshots)
    assert re.fullmatch(rf"To keep the page small the view has \d+ of {steps} steps\.", browser.text("#thinned"))
