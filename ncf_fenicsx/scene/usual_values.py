"""Values far outside what a stack and its tools can be: a slip of the pen with a valid unit, such as 2 Mm for 2 mm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ncf_fenicsx.parameters.kinds import Settings, marks_of
from ncf_fenicsx.parameters.units import Quantity


def unusual(table: Settings, prefix: str = "") -> Iterator[str]:
    """Cautions on the values of a table and of those in it, each with its key and natural unit."""
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), f"{prefix}{name}"
        quantity = next((mark for mark in marks_of(field)[0] if isinstance(mark, Quantity)), None)
        for number, item in _items(value):
            path = key if number is None else f"{key}.{number}"
            if isinstance(item, Settings):
                yield from unusual(item, f"{path}.")
            elif quantity is not None and isinstance(item, float) and (doubt := quantity.doubt(item)):
                yield f"{path}: {doubt}"


def _items(value: Any) -> Iterator[tuple[int | None, Any]]:
    """A value, or the items of a list with their numbers."""
    if isinstance(value, tuple):
        yield from enumerate(value)
    else:
        yield None, value
