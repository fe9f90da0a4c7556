"""Tables that are made from the package at each build: keys of a scene, columns of a table of results."""

from __future__ import annotations

import importlib
from typing import Any, ClassVar

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from ncf_fenicsx.scene.keys import reference


class Table(SphinxDirective):
    """A directive that stands for lines of Markdown."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """The parsed lines."""
        found = nodes.container()
        self.state.nested_parse(StringList(self.lines(self.arguments[0]), source=""), self.content_offset, found)
        return found.children

    def lines(self, name: str) -> list[str]:
        """Markdown for the directive's argument."""
        raise NotImplementedError


class SceneKeys(Table):
    """``{scene-keys} stack solver``: the keys of some tables of a scene; ``rest`` for what is left."""

    shown: ClassVar[set[str]] = set()
    final_argument_whitespace = True

    def lines(self, name: str) -> list[str]:
        """Heading and rows of the table of keys."""
        head, rule, *rows = reference().splitlines()
        if name == "rest":
            wanted = [row for row in rows if row not in self.shown]
        else:
            tables = name.split()
            wanted = [row for row in rows if _table_of(row) in tables]
            missing = set(tables) - {_table_of(row) for row in rows}
            if missing:
                raise self.error(f"no key of a scene is in {', '.join(sorted(missing))}")
        self.shown.update(wanted)
        return [head, rule, *wanted]


def _table_of(row: str) -> str:
    """``laws.shear`` of the row of ``laws.shear.modulus``, ``tool`` of that of ``tool(sphere).radius``."""
    key = row.split("`")[1]
    words = key.split("(")[0].split(".") if key.startswith("tool(") else key.replace("(", ".").split(".")
    return ".".join(words[:2]) if words[0] == "laws" else words[0]


class Columns(Table):
    """``{columns} module.NAME``: name, unit and meaning of the columns that a table of the package names."""

    def lines(self, name: str) -> list[str]:
        """Heading and rows, or the names in one line where the table has nothing but names."""
        module, _, attribute = name.rpartition(".")
        columns = getattr(importlib.import_module(module), attribute)
        if not isinstance(columns, dict):
            return [", ".join(f"`{column}`" for column in columns)]
        rows = [f"| `{column}` | {unit} | {meaning} |" for column, (unit, meaning) in columns.items()]
        return ["| column | unit | meaning |", "|---|---|---|", *rows]


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directives."""
    app.add_directive("scene-keys", SceneKeys)
    app.add_directive("columns", Columns)
    app.connect("source-read", lambda _, name, __: SceneKeys.shown.clear() if name == "scenes" else None)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
