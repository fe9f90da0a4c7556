"""Every key of a scene file with its unit, default and meaning, from the scene's own definition."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_origin

from pydantic.fields import FieldInfo

from ncf_fenicsx.parameters.kinds import Choice, Settings, kinds, marks_of
from ncf_fenicsx.parameters.units import PenaltyField, Quantity
from ncf_fenicsx.scene.scene import Scene


def reference() -> str:
    """Markdown table of all keys."""
    rows = ["| key | unit | default | meaning |", "|---|---|---|---|"]
    rows += [f"| `{key}` | {unit} | {default} | {meaning} |" for key, unit, default, meaning in keys()]
    return "\n".join(rows)


def keys() -> Iterator[tuple[str, str, str, str]]:
    """Key, unit, default and meaning of every field of a scene."""
    yield from _keys_of(Scene, "")


def _keys_of(table: type[Settings], prefix: str) -> Iterator[tuple[str, str, str, str]]:
    for name, field in table.model_fields.items():
        yield from _keys_of_field(prefix + name, field)


def _keys_of_field(key: str, field: FieldInfo) -> Iterator[tuple[str, str, str, str]]:
    choice, entry = _choice_of(field), _entry_of(field)
    if choice is not None:
        known = sorted(kinds(choice.family))
        yield f"{key}.kind", "", f'"{choice.default}"', f"{field.description}: {', '.join(known)}"
        for having, name, shared in _fields_of_kinds(choice.family):
            label = "" if having == known else f"({', '.join(having)})"
            yield from _keys_of_field(f"{key}{label}.{name}", shared)
    elif entry is not None:
        listed = get_origin(field.annotation) is tuple
        yield from _keys_of(entry, f"{key}.N." if listed else f"{key}.")
    else:
        yield key, _unit(field), _default(field), field.description or ""


def _fields_of_kinds(family: str) -> list[tuple[list[str], str, FieldInfo]]:
    """Each field of a family's kinds once: the kinds that have just that field, its name, and itself."""
    found: dict[str, tuple[list[str], str, FieldInfo]] = {}
    for kind, table in sorted(kinds(family).items()):
        for name, field in table.model_fields.items():
            found.setdefault(f"{name} {field!r}", ([], name, field))[0].append(kind)
    return list(found.values())


def _entry_of(field: FieldInfo) -> type[Settings] | None:
    """Table that a field is, or is a list of."""
    items = (field.annotation, *getattr(field.annotation, "__args__", ()))
    return next((item for item in items if isinstance(item, type) and issubclass(item, Settings)), None)


def _choice_of(field: FieldInfo) -> Choice | None:
    return next((mark for mark in marks_of(field)[0] if isinstance(mark, Choice)), None)


def _unit(field: FieldInfo) -> str:
    return next((mark.symbol for mark in marks_of(field)[0] if isinstance(mark, Quantity | PenaltyField)), "")


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.get_default(call_default_factory=True)
    if default is None:
        return "none"
    return str(list(default)).replace("'", '"') if isinstance(default, tuple) else str(default)
