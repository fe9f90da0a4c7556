"""The page in a browser: the view and its controls, what is read in it, that nothing complains or leaves the page."""

import csv
import io
import json
import re
import time

import meshio
import numpy as np
import pytest
from browser import NARROW, PAGE, WIDE, all_readings, step_of

from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial
PICTURE = "return document.querySelector('.view canvas').toDataURL();"
CURVE = "return [...document.querySelectorAll('figure')].find((f) => f.curve.content.title === arguments[0]).curve"


@pytest.fixture
def page(browser, results):
    browser.open(results / PAGE)
    return browser


def picture(browser):
    """The canvas of the view, after its next frame."""
    browser.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    return browser.run(PICTURE)


@pytest.mark.parametrize("size", [WIDE, NARROW])
@pytest.mark.parametrize("dark", [False, True])
def test_opens_quietly_at_each_width(browser, results, size, dark):
    browser.open(results / PAGE, size, dark)
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.overflow() <= 0
    background = browser.run("return getComputedStyle(document.body).backgroundColor")
    assert (background == "rgb(255, 255, 255)") != dark


@pytest.mark.parametrize(
    ("field", "factor", "of_cells", "share"),
    [
        ("volume_fraction", 1, True, 1.0),
        ("volume_fraction", 1, True, 0.5),
        ("stress_33", 1e-3, True, 1.0),
        ("permeability_across", 1, True, 1.0),
        ("contact_pressure", 1e-3, False, 1.0),
        ("gap", 1e3, False, 1.0),
        ("slip", 1e3, False, 0.5),
        ("displacement", 1e3, False, 1.0),
    ],
)
def test_values_read_equal_the_field_file(page, results, field, factor, of_cells, share):
    snapshots = Results.read(results).snapshots
    number = round(share * (len(snapshots) - 1))
    page.change("step", number)
    page.change("field", field, "change")
    mesh = meshio.read(results / snapshots[number][1])
    exact = mesh.cell_data[field][0] if of_cells else mesh.point_data[field]
    exact = factor * (np.linalg.norm(exact, axis=1) if exact.ndim > 1 else exact)
    found = all_readings(page)
    assert len(found) > 5
    room = 1.1 * step_of(page) + 1e-6 * np.abs(exact).max()  # the page states two digits; and single precision
    for place, value in found.items():
        assert value == pytest.approx(exact[place], abs=room), place


def test_the_slider_shows_another_step(page, results):
    before = picture(page)
    assert page.text("#shown-time").endswith(
        f"step {len(Results.read(results).snapshots)} of {len(Results.read(results).snapshots)}"
    )
    slider = page.driver.find_element("id", "step")
    slider.send_keys("\ue011")  # Home
    assert "step 1 of" in page.text("#shown-time")
    slider.send_keys("\ue014")  # arrow to the right
    assert "step 2 of" in page.text("#shown-time")
    assert picture(page) != before


def test_play_goes_on_and_stops(page):
    page.press("play")
    first = page.text("#shown-time")
    page.wait(f"return document.getElementById('shown-time').textContent !== {json.dumps(first)}")
    page.press("play")
    held = page.text("#shown-time")
    time.sleep(0.6)
    assert page.text("#shown-time") == held


def test_colours_over_one_step_have_its_range(page):
    page.change("step", 1)
    low, high = (float(page.text(f"#{name}")) for name in ("low", "high"))
    page.change("range", "one", "change")
    assert float(page.text("#high")) < high
    assert float(page.text("#low")) >= low
    ends = re.search(r": (\S+) to (\S+)$", page.text("#summary"))
    assert ends.groups() == (page.text("#low"), page.text("#high"))


def test_a_cut_shows_the_cells_behind_it(page, results):
    mesh = meshio.read(results / Results.read(results).snapshots[-1][1])
    end = mesh.points[mesh.cells_dict["hexahedron"]].max(axis=1)
    page.change("cut-axis", "0", "change")
    page.change("cut", 55)
    picture(page)
    assert page.text("#shown-cut") == "6.6 mm"
    seen = sorted(all_readings(page))
    assert len(seen) > 3
    assert (end[seen, 0] > 6.6e-3).all()
    assert not page.run("return document.getElementById('cut').disabled")


SECTION = """
const [axis, done] = arguments, view = document.querySelector('.view').view, {faces, model} = view;
const at = (i, along) => {
  const [a, b] = [faces.nodes[i], faces.others[i]].map((node) => model.points[3 * node + along]);
  return a + faces.shares[i] * (b - a);
};
let area = 0, lowest = Infinity;
for (let face = 0; face < faces.cells.length; face++) {
  const corners = [0, 1, 2, 3].map((corner) => [0, 1, 2].map((along) => at(4 * face + corner, along)));
  lowest = Math.min(lowest, ...corners.map((corner) => corner[axis]));
  const [u, v] = [0, 1, 2].filter((along) => along !== axis);
  const cross = ([a, b, c]) => Math.abs((b[u] - a[u]) * (c[v] - a[v]) - (c[u] - a[u]) * (b[v] - a[v])) / 2;
  const flat = corners.every((corner) => Math.abs(corner[axis] - corners[0][axis]) < 1e-7);
  if (flat && corners[0][axis] < view.extent(axis)[1] - 1e-7)
    area += cross(corners) + cross([corners[0], corners[2], corners[3]]);
}
done([lowest, area]);
"""


@pytest.mark.parametrize(
    ("axis", "share", "place", "area"), [(0, 41.7, 5.004, 24.0), (0, 50, 6, 24.0), (1, 30, 1.8, 48.0)]
)
def test_a_cut_is_a_plane_that_goes_through_cells(page, axis, share, place, area):
    """Nothing is left before it, and the section is closed: it has the area of the stack."""
    page.change("step", 0)
    page.change("cut-axis", str(axis), "change")
    page.change("cut", share)
    page.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    lowest, found = page.driver.execute_async_script(SECTION, axis)
    assert 1e3 * lowest == pytest.approx(place, rel=1e-4)
    assert 1e6 * found == pytest.approx(area, rel=1e-4)
    assert page.complaints() == []


def test_a_cut_follows_the_slider_within_a_cell(page):
    page.change("cut-axis", "0", "change")
    seen = set()
    for share in (50.5, 51.0, 51.5):
        page.change("cut", share)
        seen.add(picture(page))
    assert len(seen) == 3


def test_the_view_is_seen_from_its_sides(page):
    seen = {picture(page)}
    for side in ("front", "side", "above"):
        page.change("side", side, "change")
        seen.add(picture(page))
    assert len(seen) == 4


def test_sections_follow_the_field_and_are_its_means_through_a_layer(page, results):
    mesh = meshio.read(results / Results.read(results).snapshots[-1][1])
    middle = mesh.points[mesh.cells_dict["hexahedron"]].mean(axis=1)
    for field, label in (
        ("volume_fraction", "Fibre volume fraction"),
        ("permeability_across", "Permeability across the fibres"),
    ):
        page.change("field", field, "change")
        rows = list(csv.reader(io.StringIO(page.run(f"{CURVE}.csv()", f"{label} along x, through the chosen place"))))
        table = np.array(rows[1:], dtype=float)
        for layer in (1, 2):
            here = np.flatnonzero((mesh.cell_data["layer"][0] == layer) & (middle[:, 1] < 3e-3))
            here = here[np.argsort(middle[here, 0])]
            assert np.allclose(table[:, 0], 1e3 * middle[here, 0])
            assert np.allclose(table[:, layer], mesh.cell_data[field][0][here], rtol=1e-4)


def test_curves_through_the_stack_are_those_of_the_chosen_places(page, results):
    click = (
        "const c = document.querySelector('.view canvas'), box = c.getBoundingClientRect();"
        "const [x, y, shiftKey] = arguments;"
        "c.dispatchEvent(new MouseEvent('click',"
        "  {clientX: box.left + x * box.width, clientY: box.top + y * box.height, shiftKey}));"
    )
    page.run(click, 0.42, 0.5, False)
    page.run(click, 0.6, 0.5, True)
    mesh = meshio.read(results / Results.read(results).snapshots[-1][1])
    middle = 1e3 * mesh.points[mesh.cells_dict["hexahedron"]].mean(axis=1)
    rows = list(csv.reader(io.StringIO(page.run(f"{CURVE}.csv()", "Fibre volume fraction through the stack"))))
    table = np.array(rows[1:], dtype=float)
    assert len(rows[0]) == 3
    assert rows[0][1] != rows[0][2]
    for number, label in enumerate(rows[0][1:], start=1):
        at = [float(part) for part in re.fullmatch(r"at (\S+), (\S+) mm", label).groups()]
        here = np.flatnonzero(np.hypot(*(middle[:, :2] - at).T) < 1e-2)
        here = here[np.argsort(middle[here, 2])]
        assert np.allclose(table[:, number], mesh.cell_data["volume_fraction"][0][here], atol=1e-5)
    page.run(click, 0.42, 0.5, False)
    assert len(page.run(f"{CURVE}.csv()", "Fibre volume fraction through the stack").splitlines()[0].split('","')) == 2


def test_controls_change_the_picture(page):
    seen = {picture(page)}
    for control, value in (("scale", 6), ("apart", 15)):
        page.change(control, value)
        seen.add(picture(page))
    for control in ("edges", "rigid", "mirror"):
        page.press(control)
        seen.add(picture(page))
    assert len(seen) == 6
    assert page.complaints() == []


def test_layers_apart_stay_in_the_frame(page):
    page.change("apart", 20)
    corner = page.run(
        "const c = document.querySelector('.view canvas'), g = c.getContext('webgl2'), p = new Uint8Array(4);"
        "g.readPixels(2, 2, 1, 1, g.RGBA, g.UNSIGNED_BYTE, p); return [...p];"
    )
    assert corner[:3] == [255, 255, 255]


def test_keys_turn_zoom_and_read(page):
    canvas = page.driver.find_element("css selector", ".view canvas")
    start = picture(page)
    canvas.send_keys("\ue014\ue014")
    turned = picture(page)
    canvas.send_keys("+")
    zoomed = picture(page)
    canvas.send_keys("0")
    assert len({start, turned, zoomed}) == 3
    assert picture(page) == start
    canvas.send_keys("\ue007")
    assert "layer" in page.text(".view .read")


def test_curves_are_the_history(page, results):
    history = Results.read(results).history
    rows = list(csv.reader(io.StringIO(page.run(f"{CURVE}.csv()", "Force"))))
    assert rows[0] == ["tool displacement in mm", "tool 1, N", "supports, N"]
    table = np.array(rows[1:], dtype=float)
    wanted = [1e3 * history["tool_displacement"], history["tool_force"], history["support_force"]]
    assert np.allclose(table, np.stack(wanted, axis=1), rtol=1e-12)
    svg = page.run(f"{CURVE}.svg()", "Force")
    assert svg.startswith("<svg")
    assert svg.count("<polyline") == 2


def test_profile_under_the_tool_is_the_field(page, results):
    mesh = meshio.read(results / Results.read(results).snapshots[-1][1])
    rows = list(csv.reader(io.StringIO(page.run(f"{CURVE}.csv()", "Pressure along x, tool 1"))))
    table = np.array(rows[1:], dtype=float)
    top = np.flatnonzero((mesh.points[:, 2] > 3.9e-3) & (mesh.points[:, 1] < 1e-9))
    top = top[np.argsort(mesh.points[top, 0])]
    exact = 1e-3 * mesh.point_data["contact_pressure"][top]
    pressed = 1 + np.flatnonzero(exact)[-1]
    assert pressed < len(table) < len(top)  # as far as there is pressure, and a little more
    top, exact = top[: len(table)], exact[: len(table)]
    assert np.allclose(table[:, 0], 1e3 * mesh.points[top, 0], atol=1e-5)
    assert np.allclose(table[:, 1], exact, atol=1e-4 * exact.max())
