"""Formulas without a network: KaTeX from Debian's package is copied beside the pages.

MathJax is the usual choice, but Sphinx loads it from the network, and Debian's local copy takes 40 MB. Images of
formulas (``sphinx.ext.imgmath``) need a LaTeX installation and do not scale with the text. KaTeX takes 2 MB.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ConfigError
from sphinx.writers.html5 import HTML5Translator

KATEX = Path("/usr/share/javascript/katex")
SCRIPTS = ("katex/katex.min.js", "render_math.js")


def inline(translator: HTML5Translator, node: Any) -> None:
    """Write a formula within a line as its source."""
    translator.body.append(f'<span class="math notranslate nohighlight">{translator.encode(node.astext())}</span>')
    raise nodes.SkipNode


def block(translator: HTML5Translator, node: Any) -> None:
    """Write a formula on a line of its own as its source."""
    translator.body.append(f'<div class="math notranslate nohighlight">{translator.encode(node.astext())}</div>')
    raise nodes.SkipNode


def copy_katex(app: Sphinx) -> None:
    """Copy script, style and fonts to the built pages.

    Raises:
        ConfigError: the package is not installed.
    """
    if app.builder.format != "html":
        return
    if not KATEX.is_dir():
        raise ConfigError(f"{KATEX} is missing: install Debian's package libjs-katex")
    target = Path(app.outdir) / "_static" / "katex"
    target.mkdir(parents=True, exist_ok=True)
    for name in ("katex.min.js", "katex.min.css"):
        shutil.copyfile(KATEX / name, target / name)
    shutil.copytree(KATEX / "fonts", target / "fonts", dirs_exist_ok=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the renderer."""
    app.add_html_math_renderer("katex", (inline, None), (block, None))
    app.add_css_file("katex/katex.min.css")
    for script in SCRIPTS:
        app.add_js_file(script, loading_method="defer")
    app.connect("builder-inited", copy_katex)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
