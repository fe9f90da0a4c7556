"""The manual: ``docker/run sphinx-build -W --keep-going -b html docs build/docs``, then open ``build/docs/index.html``.

Tables of keys and columns and the pages of the API reference are made from the package at each build, so they follow
it. Nothing that is made is kept in the repository.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "extensions"), str(HERE.parent)]

from ncf_fenicsx.version import VERSION  # noqa: E402

project, author, release = "ncf_fenicsx", "the authors of ncf_fenicsx", VERSION
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "api_pages",
    "generated_tables",
    "offline_math",
]
exclude_patterns = ["extensions", "static"]

myst_enable_extensions = ["dollarmath"]
smartquotes = False  # defaults are to be copied as they are
myst_heading_anchors = 3
"""Headings down to this level can be linked to, as ``page.md#a-heading``: the same anchors as on a git server."""
html_math_renderer = "katex"

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "model_config"}
napoleon_numpy_docstring = False
napoleon_use_ivar = True
"""Attributes of a class as fields of its description: they do not clash with its properties of the same name."""

html_theme = "furo"
html_title = f"ncf_fenicsx {VERSION}"
html_static_path = ["static"]
html_css_files = ["wide_tables.css"]
html_copy_source = False
html_show_copyright = False
