"""Pages of the API reference, one for each folder of the package, written into ``docs/api`` at each build."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from sphinx.application import Sphinx

PACKAGE = "ncf_fenicsx"
BESIDE = "beside the folders"
COLON = "\0"
"""Stands for a colon in docstrings of constants and attributes: napoleon would take what is before it for a type."""
SPECIAL = str.maketrans({"*": r"\*", "|": r"\|", "_": r"\_"})
"""What reStructuredText would take for markup where a docstring means a formula."""


def write_pages(app: Sphinx) -> None:
    """Replace all pages."""
    source = Path(app.srcdir)
    package, folder = source.parent / PACKAGE, source / "api"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for path in sorted(package.glob("*/__init__.py")):
        name = path.parent.name
        (folder / f"{name}.rst").write_text("\n".join(_page(path.parent, name, f"{PACKAGE}.{name}")), encoding="utf-8")
    (folder / "package.rst").write_text("\n".join(_page(package, BESIDE, PACKAGE)), encoding="utf-8")


def _page(folder: Path, title: str, module: str) -> Iterator[str]:
    yield from (title, "=" * len(title), "", f".. automodule:: {module}", "")
    for path in sorted(folder.glob("[a-z]*.py")):
        yield from (path.stem, "-" * len(path.stem), "", f".. automodule:: {module}.{path.stem}")
        yield from ("   :members:", "   :show-inheritance:", "")


def hide_colons(_app: Sphinx, what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Keep napoleon from reading a sentence with a colon as a type and a meaning."""
    if what in ("attribute", "data", "property"):
        lines[:] = [line.replace(":", COLON) for line in lines]


def escape(_app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Show formulas in docstrings as they are; what stands between double backquotes is left alone."""
    for number, line in enumerate(lines):
        parts = line.replace(COLON, ":").split("``")
        lines[number] = "``".join(part if index % 2 else _plain(part) for index, part in enumerate(parts))


def _plain(text: str) -> str:
    """Text without markup, except for the fields that napoleon has made (``:param name:``)."""
    words = text.split(":")
    if text.lstrip().startswith(":") and len(words) > 2:
        return ":".join([*words[:2], ":".join(words[2:]).translate(SPECIAL)])
    return text if text.lstrip().startswith("..") else text.translate(SPECIAL)


def signature(_app: Sphinx, what: str, _name: str, thing: object, *_: Any) -> tuple[str, None] | None:
    """None for tables of a scene: their keys, with units and defaults, have a page of their own."""
    return ("", None) if what == "class" and isinstance(thing, type) and issubclass(thing, BaseModel) else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the pages before they are read."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", hide_colons, priority=100)
    app.connect("autodoc-process-docstring", escape, priority=900)
    app.connect("autodoc-process-signature", signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
