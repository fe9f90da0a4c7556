"""Small pieces of HTML. All text of a scene or a run goes through `text`, so that it is never markup."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any


def text(words: object) -> str:
    """Words as they are to be read, whatever signs they have."""
    return html.escape(str(words), quote=True)


def element(tag: str, inner: str, **attributes: object) -> str:
    """An element around HTML; ``data_row`` is the attribute ``data-row``, ``class_`` is ``class``."""
    names = {name: name.rstrip("_").replace("_", "-") for name in attributes}
    given = "".join(f' {names[name]}="{text(value)}"' for name, value in attributes.items())
    return f"<{tag}{given}>{inner}</{tag}>"


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[object]], wide: bool = False) -> str:
    """A table of text whose first column names its rows; a wide one scrolls in place of breaking its lines."""
    top = "".join(element("th", text(name), scope="col") for name in head)
    body = "".join(
        element("tr", element("th", text(first), scope="row") + "".join(element("td", text(cell)) for cell in rest))
        for first, *rest in rows
    )
    inner = element("caption", text(caption)) + element("thead", element("tr", top)) + element("tbody", body)
    return element(
        "div",
        element("table", inner),
        class_="scroll wide" if wide else "scroll",
        tabindex=0,
        role="region",
        aria_label=caption,
    )


def folded(title: str, inner: str) -> str:
    """HTML that opens when its title is pressed."""
    return element("details", element("summary", text(title)) + inner)


def picture(path: Path, description: str) -> str:
    """A picture within the page; nothing where there is none."""
    if not path.is_file():
        return ""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img src="data:image/png;base64,{data}" alt="{text(description)}">'


def data(name: str, value: Any) -> str:
    """JSON for the page's scripts, under a name; no text in it can end the element."""
    inner = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        inner = inner.replace(sign, f"\\u{ord(sign):04x}")
    return f'<script type="application/json" id="{name}">{inner}</script>'
