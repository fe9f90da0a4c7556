"""Tables of a scene, and its parts chosen by name: every law and every tool is a `Kind` in a file of its own.

A part registers itself under its family and name when its class is defined, so a new law or tool is one new file (or
one class in a script or a test), and nothing else has to know of it.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from ncf_fenicsx.parameters.units import parse_number


def parameter(default: Any, description: str, **bounds: Any) -> Any:
    """Field of a table; its default is validated like what a reader writes, so it may be text with a unit."""
    return Field(default, validate_default=True, description=description, **bounds)


class Settings(BaseModel):
    """Frozen table of a scene: unknown keys are errors; `renamed` has former names with those of now."""

    renamed: ClassVar[dict[str, str]] = {}
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _no_unknown_key(cls, data: Any) -> Any:
        unknown = [key for key in data if key not in cls.model_fields] if isinstance(data, dict) else []
        if unknown:
            key, now = unknown[0], cls.renamed.get(unknown[0])
            advice = f"renamed; expected {now!r}" if now else "unknown key; " + nearest(key, list(cls.model_fields))
            raise PydanticCustomError("unknown_key", "{advice}", {"key": key, "value": data[key], "advice": advice})
        return data

    @model_validator(mode="before")
    @classmethod
    def _nothing_is_taken_for_another(cls, data: Any) -> Any:
        """Pydantic would read a text or true as a number, and 1 or "yes" as true: what a reader means is not sure."""
        for key, value in data.items() if isinstance(data, dict) else ():
            field = cls.model_fields.get(key)
            wrong = _no_number(value) if field is not None and _is_bare_number(field, value) else None
            words = "" if wrong is None or field is None else _expected_number(wrong, field)
            if field is not None and field.annotation is bool and not isinstance(value, bool):
                words = "expected true or false"
            if words:
                raise PydanticCustomError("mistaken", "{words}", {"key": key, "value": value, "words": words})
        return data


def _expected_number(wrong: str | bool, field: FieldInfo) -> str:
    meant = parse_number(wrong.replace(",", ".")) if isinstance(wrong, str) else None
    kind = "number" if float in marks_of(field)[1] else "whole number"
    return f"expected a {kind}" + ("" if meant is None else f" as TOML has it: {meant:g}")


def _no_number(value: Any) -> str | bool | None:
    """The first text or truth value in a value or a list of values; None without one."""
    if isinstance(value, list | tuple):
        return next((found for item in value if (found := _no_number(item)) is not None), None)
    return value if isinstance(value, str | bool) else None


def _is_bare_number(field: FieldInfo, value: Any) -> bool:
    """Whether a value of a field stands for whole or real numbers that are read as they are, one or a list of them.

    A field of numbers may take words in their place.
    """
    marks, leaves = marks_of(field)
    words = {leaf for leaf in leaves if isinstance(leaf, str)}
    if isinstance(value, str) and value in words:
        return False
    leaves -= words
    reads = any(hasattr(mark, "__get_pydantic_core_schema__") for mark in marks)
    return not reads and bool(leaves & {int, float}) and leaves <= {int, float, type(None)}


def marks_of(field: FieldInfo) -> tuple[list[Any], set[Any]]:
    """All annotations of a field, also those inside a tuple or an optional type, and the types that they are of."""
    leaves, open_types, marks = set(), [field.annotation], list(field.metadata)
    while open_types:
        current = open_types.pop()
        marks += getattr(current, "__metadata__", ())
        arguments = [item for item in getattr(current, "__args__", ()) if item is not Ellipsis]
        leaves |= set() if arguments else {current}
        open_types += arguments
    return marks, leaves


class Constants(Protocol):
    """Makes what stands for numbers in the compiled forms."""

    def __call__(self, value: float) -> Any:
        """Constant for a number."""

    def by_layer(self, values: Sequence[float]) -> Any:
        """Constant for a number for each layer, from the bottom up."""


class Kind(Settings):
    """A law or a tool, with its parameters as fields."""

    family: ClassVar[str]
    kind: ClassVar[str]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if "kind" in cls.__dict__:
            _kinds.setdefault(cls.family, {})[cls.kind] = cls

    def with_constants(self, constants: Constants) -> Self:
        """Copy whose numbers are what ``constants(value)`` makes of them.

        The compiled forms then hold the parameters as named constants: a new value needs no new compilation.
        """
        return self.model_copy(update={name: _constants(value, constants) for name, value in self})


def _constants(value: Any, constants: Constants) -> Any:
    """Constant for each number in a value: a float, or tables and lists of floats."""
    if isinstance(value, float):
        return constants(value)
    if isinstance(value, tuple):
        return tuple(_constants(item, constants) for item in value)
    if isinstance(value, Settings):
        return value.model_copy(update={name: _constants(item, constants) for name, item in value})
    return value


def impossible(key: str, value: Any, expected: str) -> PydanticCustomError:
    """Error of a value that does not go with the rest of the scene, to raise in a validator."""
    return PydanticCustomError("impossible", "{expected}", {"key": key, "value": value, "expected": expected})


_kinds: dict[str, dict[str, type[Kind]]] = {}


def families() -> list[str]:
    """Names of all families of parts."""
    return sorted(_kinds)


def kinds(family: str) -> dict[str, type[Kind]]:
    """All parts of a family, by name."""
    return dict(_kinds.get(family, {}))


def nearest(word: str, words: list[str]) -> str:
    """Advice on a misspelt word: the one meant, or all there are."""
    if not words:
        return "it takes none"
    close = difflib.get_close_matches(word, words, n=1)
    return f"did you mean {close[0]!r}?" if close else "expected one of " + ", ".join(sorted(words))


@dataclass(frozen=True)
class Choice:
    """Pydantic annotation of a part: a table with ``kind = "name"`` and that part's keys beside it."""

    family: str
    default: str

    def read(self, value: object) -> Kind:
        """The part that a table names.

        Raises:
            ValueError: not a table, or no such kind.
        """
        if isinstance(value, Kind) and value.family == self.family:
            return value
        if not isinstance(value, dict):
            raise ValueError(f'expected a table with kind = "{self.default}" or another kind of {self.family}')
        known = kinds(self.family)
        kind = value.get("kind", self.default)
        if not isinstance(kind, str) or kind not in known:
            raise PydanticCustomError(
                "unknown_kind",
                "no such {family}; {advice}",
                {"key": "kind", "value": kind, "family": self.family, "advice": nearest(str(kind), list(known))},
            )
        return known[kind].model_validate({key: item for key, item in value.items() if key != "kind"})

    @staticmethod
    def write(part: Kind) -> dict[str, Any]:
        """Table that `read` turns back into the same part."""
        return {"kind": part.kind, **part.model_dump(exclude_none=False)}

    def schema(self) -> CoreSchema:
        """Pydantic's view of one such part."""
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write)
        )

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return self.schema()


@dataclass(frozen=True)
class Choices(Choice):
    """Pydantic annotation of parts in a tuple: one table, or a list of them."""

    def read_all(self, value: object, read_list: Callable[[object], Any]) -> tuple[Kind, ...]:
        """The parts that a table or a list of tables name."""
        return read_list(value) if isinstance(value, list | tuple) else (self.read(value),)

    def write_all(self, parts: tuple[Kind, ...]) -> dict[str, Any] | list[dict[str, Any]] | None:
        """What `read_all` turns back into the same parts; None for none."""
        tables = [self.write(part) for part in parts]
        return tables[0] if len(tables) == 1 else tables or None

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return core_schema.no_info_wrap_validator_function(
            self.read_all,
            core_schema.tuple_schema([self.schema()], variadic_item_index=0),
            serialization=core_schema.plain_serializer_function_ser_schema(self.write_all),
        )


def numbered(name: str, number: int) -> str:
    """Name of the first of several, of the second, ...: ``tool``, ``tool_2``."""
    return name if number == 0 else f"{name}_{number + 1}"
