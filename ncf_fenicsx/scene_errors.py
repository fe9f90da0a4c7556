"""One clear line for whatever is wrong with a scene."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError


class SceneError(ValueError):
    """A scene that cannot be run; its message names the key, the value and what was expected."""


def one_line(error: ValidationError) -> str:
    """First error of a validation as ``key = value: what was expected``, with the number of the others."""
    errors = error.errors(include_url=False)
    first = errors[0]
    context = first.get("ctx", {})
    path = [str(item) for item in first["loc"] if not _is_type_name(item)]
    if "key" in context:
        path.append(str(context["key"]))
    value = context.get("value", first["input"])
    words = first["msg"].removeprefix("Value error, ").replace("Input should be", "expected").replace("\n", " ")
    others = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    if first["type"] == "value_error" and isinstance(value, dict):
        return f"{'.'.join(path) or 'scene'}: {words}{others}"
    return f"{'.'.join(path) or 'scene'} = {_shown(value)}: {words}{others}"


def _is_type_name(item: Any) -> bool:
    """Pydantic names the tried member of a union in the location; a reader's keys have no brackets or capitals."""
    return isinstance(item, str) and (item in {"int", "constrained-int"} or "[" in item)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
