"""One clear line for whatever is wrong with a scene."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

_WORDS = {
    "model_type": "expected a table",
    "tuple_type": "expected a list",
    "too_short": "expected at least {min_length} entries",
    "missing": "expected one more entry",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
    "int_type": "expected a whole number",
    "float_parsing": "expected a number",
    "bool_parsing": "expected true or false",
}
"""Own words where pydantic's speak of Python; its other messages are clear to a reader of TOML."""


class SceneError(ValueError):
    """A scene that cannot be run; its message names the key, the value and what was expected."""


def one_line(error: ValidationError) -> str:
    """First error of a validation as ``key = value: what was expected``, with the number of the others.

    A list whose entry is wrong counts as too short, too: what lies around the first error is no other.
    """
    errors = error.errors(include_url=False)
    first = errors[0]
    more = sum(first["loc"][: len(other["loc"])] != other["loc"] for other in errors[1:])
    context = first.get("ctx", {})
    path = [str(item) for item in first["loc"] if not _is_type_name(item)]
    if "key" in context:
        path.append(str(context["key"]))
    value = context.get("value", first["input"])
    words = _WORDS.get(first["type"], "").format(**context) or first["msg"].removeprefix("Value error, ").replace(
        "\n", " "
    )
    words = words.replace("Input should be", "expected").replace(" 1 entries", " one entry")
    others = f" (and {more} more)" if more else ""
    if first["type"] == "value_error" and isinstance(value, dict):
        return f"{'.'.join(path) or 'scene'}: {words}{others}"
    return f"{'.'.join(path) or 'scene'} = {_shown(value)}: {words}{others}"


def _is_type_name(item: Any) -> bool:
    """Pydantic names the tried member of a union in the location; a reader's keys have no brackets or capitals."""
    return isinstance(item, str) and (item in {"int", "constrained-int"} or "[" in item)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
