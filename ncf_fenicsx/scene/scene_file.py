"""Scene files as nested tables: their encoding, TOML, and values that the command line replaces."""

from __future__ import annotations

import codecs
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError

WRITTEN = "scene_as_written.toml"
"""Name under which results keep the scene file as its author wrote it."""
MARKED = {
    codecs.BOM_UTF32_LE: "UTF-32",
    codecs.BOM_UTF32_BE: "UTF-32",
    codecs.BOM_UTF16_LE: "UTF-16",
    codecs.BOM_UTF16_BE: "UTF-16",
}
"""Byte-order marks of encodings that are no TOML; UTF-32 first, whose mark begins with that of UTF-16."""


def read_table(path: Path) -> dict[str, Any]:
    """Nested tables of a scene file.

    Raises:
        SceneError: the file cannot be read, is not UTF-8, or is not TOML.
    """
    try:
        text = decoded(path, path.read_bytes())
        return tomllib.loads(text)
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}; expected a scene file") from error
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{path}: not TOML: {error}") from error


def decoded(path: Path, content: bytes) -> str:
    """Text of a file's content in UTF-8, without the byte-order mark that some editors write.

    Raises:
        SceneError: the content is in another encoding; it is named where its bytes tell it.
    """
    encoding = _wide_encoding(content)
    if encoding is not None:
        raise SceneError(f"{path}: is {encoding}; save it as UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # an offset counts from behind the mark
        body = content.removeprefix(codecs.BOM_UTF8)
        line, byte = body[: error.start].count(b"\n") + 1, body[error.start]
        letter = bytes([byte]).decode("cp1252", errors="replace")
        raise SceneError(
            f"{path}: not UTF-8: line {line} has the byte 0x{byte:02x}, {letter!r} in Latin-1 and Windows-1252; "
            "save it as UTF-8"
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _wide_encoding(content: bytes) -> str | None:
    """UTF-32 or UTF-16 by its byte-order mark, or UTF-16 by its zero bytes, which no text in UTF-8 has; else None."""
    for mark, name in MARKED.items():
        if content.startswith(mark):
            return name
    # a scene is mostly ASCII, of which UTF-16 has a zero in every other byte
    halves = content[0::2], content[1::2]
    return "UTF-16" if any(half and 2 * half.count(0) > len(half) for half in halves) else None


def apply_override(data: dict[str, Any], text: str) -> None:
    """Set one nested key of a table from ``key.of.table=value``; a number in the key picks from a list.

    Raises:
        SceneError: the text has no ``=``, or its key leads through something that is no table.
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise SceneError(f"--set {text}: expected KEY=VALUE, such as stack.layers=2")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    *tables, last = key.strip().split(".")
    target: Any = data
    try:
        for name in tables:
            target = target[int(name)] if isinstance(target, list) else target.setdefault(name, {})
        target[int(last) if isinstance(target, list) else last] = parsed
    except (AttributeError, IndexError, TypeError, ValueError) as error:
        raise SceneError(
            f"--set {text}: no such table in the scene; expected a key such as stack.layers, or "
            "tool.path.0.speed for the first of a list"
        ) from error


def as_written(path: Path, overrides: Sequence[str]) -> str:
    """Text of a scene file, with what a command line replaces as comments on top.

    Raises:
        SceneError: the file is in another encoding.
    """
    replaced = "".join(f"# --set {text}\n" for text in overrides)
    return replaced + decoded(path, path.read_bytes())


def without_none(table: Any) -> Any:
    """Nested tables and lists without the keys that have no value, which TOML cannot write."""
    if isinstance(table, dict):
        return {key: without_none(value) for key, value in table.items() if value is not None}
    return [without_none(item) for item in table] if isinstance(table, list | tuple) else table
