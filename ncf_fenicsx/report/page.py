"""One self-contained HTML page of a results folder, or of several side by side: it opens without a network."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report import encoding, first_screen, repeat
from ncf_fenicsx.report.curves import abscissae, curves
from ncf_fenicsx.report.markup import data, element, folded, picture, table, text
from ncf_fenicsx.report.model import encode_model
from ncf_fenicsx.report.reading import Results

PAGE = "report.html"
MOST_BYTES = 10_000_000
"""Size of a page at most: what mail servers take."""
COLOUR_BYTES = 2000
"""Of that for the colour map."""
MOST_ROWS = 200
"""Rows of the table of the history."""
VIEWER = Path(__file__).parent / "viewer"
RUN_SCRIPTS = ("vendor", "decode", "geometry", "view", "picture", "curve", "profiles", "history", "main")
"""Files of the viewer that a page of runs needs, in their order."""
RULES = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What a browser lets the page do: nothing that leaves it."""


def write_report(folder: Path) -> Path:
    """Write ``report.html`` of a results folder, also of an unfinished one.

    Raises:
        SceneError: it is no results folder.
        ResultError: the page cannot be written.
    """
    results = Results.read(folder)
    found = curves(results) if results.rows else []
    main = first_screen.screen(results) + view(1, _fallback(results)) + places([one["id"] for one in found])
    main += first_screen.explanations() + _history(results) + repeat.section(results)
    return write_page(folder / PAGE, results.scene.title, main, [run_data(results, spare(main))])


def spare(main: str) -> int:
    """Bytes that a page has for the data of its runs, with this HTML and all scripts."""
    return MOST_BYTES - len(document("", main, RUN_SCRIPTS).encode()) - COLOUR_BYTES


def run_data(results: Results, most_bytes: int) -> dict[str, Any]:
    """What the scripts of a page draw of a run, in about so many bytes at most: as many steps as they hold."""
    history = {name: encoding.numbers(values) for name, values in (results.history | results.errors).items()}
    drawn = {
        "name": str(results.folder.name),
        "title": results.scene.title,
        "history": history,
        "curves": curves(results) if results.rows else [],
        "abscissae": abscissae(results) if results.rows else [],
    }
    return drawn | {"model": encode_model(results, most_bytes - len(json.dumps(drawn)))}


def write_page(path: Path, title: str, main: str, runs: list[dict[str, Any]]) -> Path:
    """Write a page of runs: its HTML, and what its scripts draw of each run (`run_data`).

    Raises:
        ResultError: it cannot be written.
    """
    from matplotlib import colormaps  # takes long to load, and most that import this file write no page

    colours = (255 * colormaps["viridis"](np.linspace(0, 1, 256))).round().astype(np.uint8).tobytes()
    main += element("script", base64.b64encode(colours).decode("ascii"), type="text/plain", id="colour-map")
    page = document(title, main + data("runs", runs), RUN_SCRIPTS)
    replace(path, lambda beside: beside.write_text(page, encoding="utf-8"))
    return path


def document(title: str, main: str, scripts: tuple[str, ...]) -> str:
    """A whole page with its styles, its scripts by name, and a heading."""
    style = "\n".join((VIEWER / f"{name}.css").read_text(encoding="utf-8") for name in ("vendor", "page"))
    code = "".join(f"<script>\n{_script(name)}</script>\n" for name in scripts)
    heading = element("h1", text(title)) + '<button type="button" id="theme">Light or dark</button>'
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{text(RULES)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'{element("title", text(title))}\n<link rel="icon" href="data:,">\n<style>\n{style}</style>\n</head>\n'
        f"<body>\n{element('header', heading)}\n{element('main', main)}\n{code}</body>\n</html>\n"
    )


def _script(name: str) -> str:
    return (VIEWER / f"{name}.js").read_text(encoding="utf-8").replace("</script", "<\\/script")


def _fallback(results: Results) -> str:
    """What stands in place of the view where it cannot be drawn."""
    shown = picture(results.folder / "summary.png", "Force, Vf through the stack and deformed sections")
    return element("div", element("p", "", id="no-view", role="status") + shown, id="fallback")


def view(number: int, fallback: str) -> str:
    """Canvases of the 3-D view with their controls, and what is shown without it."""
    described = "Deformed stack. Drag or arrow keys turn it, plus and minus zoom, 0 resets, Enter reads its middle."
    canvases = "".join(
        element(
            "div",
            f'<canvas tabindex="0" role="img" aria-label="{text(described)}"></canvas>'
            '<p class="name"></p><p class="read" aria-live="polite"></p>',
            class_="view",
        )
        for _ in range(number)
    )
    controls = (VIEWER / "controls.html").read_text(encoding="utf-8")
    drawn = element("div", element("div", canvases, class_="views") + controls, id="view", hidden="")
    heading = element("h2", "The stack in 3-D", id="view-of-the-stack")
    return element("section", heading + fallback + drawn, aria_label="3-D view")


def places(anchors: Sequence[str] = ()) -> str:
    """The section of curves, which the scripts draw: those with an anchor in its figure, the others after them."""
    figures = "".join(element("figure", "", id=one) for one in anchors)
    over = '<p class="row"><label>Over <select id="over"></select></label></p>'
    drawn = f'<div id="curves">{figures}</div><p id="flat" class="note"></p>'
    return element("section", f"<h2>Curves</h2>{over}{drawn}", aria_label="Curves")


def _history(results: Results) -> str:
    """The history as a table for those who cannot see curves; thinned out where it is long."""
    if not results.rows:
        return ""
    rows = np.unique(np.linspace(0, results.rows - 1, min(results.rows, MOST_ROWS)).round().astype(int))
    names = list(results.history)
    cells = [[f"{results.history[name][row]:.6g}" for name in names] for row in rows]
    shown = "all rows" if len(rows) == results.rows else f"{len(rows)} of {results.rows} rows"
    caption = f"history.csv, {shown}, in SI units"
    inner = folded("The curves as a table", table(caption, names, cells, wide=True))
    return element("section", inner, aria_label="History", class_="screen-only")
