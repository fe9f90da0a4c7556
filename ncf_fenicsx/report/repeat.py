"""HTML of all that is needed to repeat a run: scene, versions, machine, command, hashes; and where its time went."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ncf_fenicsx.report.markup import element, folded, table, text
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.scene.scene_file import WRITTEN

HASHED = (WRITTEN, "scene.toml", "history.csv", "run.json")


def section(results: Results) -> str:
    """The last section of a page."""
    inner = element("h2", "To repeat it") + _times(results) + _origin(results) + _hashes(results)
    for name, title in ((WRITTEN, "The scene as written"), ("scene.toml", "The scene with all defaults, in SI units")):
        path = results.folder / name
        if path.is_file():
            written = text(path.read_text(encoding="utf-8"))
            inner += folded(title, element("pre", written, tabindex=0, id=f"file-{path.stem}"))
    return element("section", inner, aria_label="To repeat it", class_="screen-only")


def _times(results: Results) -> str:
    """Seconds by phase with bars."""
    seconds: dict[str, float] = results.record.get("seconds", {})
    longest = max(seconds.values(), default=0.0)
    if not longest:
        return ""
    rows = "".join(
        element(
            "tr",
            element("th", text(name), scope="row")
            + element("td", text(f"{value:.3f}"), class_="value")
            + f'<td class="bar"><meter min="0" max="{longest}" value="{value}"></meter></td>',
        )
        for name, value in sorted(seconds.items(), key=lambda item: -item[1])
    )
    return element("table", f"<caption>Wall time by phase in s</caption><tbody>{rows}</tbody>", class_="figures")


def _origin(results: Results) -> str:
    record = results.record
    rows = [(name, version) for name, version in record.get("versions", {}).items()]
    rows += [(name, record[name]) for name in ("machine", "ranks", "command") if name in record]
    return table("Versions, machine, command", ("what", "value"), rows) if rows else ""


def _hashes(results: Results) -> str:
    """SHA-256 of the small files, and of the mesh file if there is one."""
    paths = [results.folder / name for name in HASHED]
    if results.scene.stack.mesh is not None:
        paths.append(Path(results.scene.stack.mesh))
    rows = [(path.name, hashlib.sha256(path.read_bytes()).hexdigest()) for path in paths if path.is_file()]
    return table("SHA-256", ("file", "hash"), rows)
