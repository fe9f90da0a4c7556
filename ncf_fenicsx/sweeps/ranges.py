"""What a sweep varies, as text: ``tool.radius=2..5 mm:4`` is four radii.

======================================  =====================================================================
text                                    meaning
======================================  =====================================================================
``key=0.5,1,2 MPa``                     these values; the last one's unit is that of numbers without any
``key=stitched,bonded``                 words, tables ``{...}`` and lists ``[...]`` as in a scene file
``key=2..5 mm:4``                       four values, evenly spaced, both ends among them
``key=1e4..1e7 Pa:4:log``               the same with an even ratio
``key=2..5 mm``                         all values between; for plans that choose them
``a,b=1,2 mm``                          two keys that have the same value
``a,b=(2 mm, 1),(3 mm, 2)``             two keys that change together, a value for each
======================================  =====================================================================
"""

from __future__ import annotations

from dataclasses import dataclass

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import NUMBER, parse_number

OPENING, CLOSING, QUOTES = "([{", ")]}", "\"'"


@dataclass(frozen=True)
class Vary:
    """Keys that change together, and their values as a scene file has them.

    Attributes:
        text: as it was given.
        keys: of the scene.
        values: a value for each key, one tuple a level; empty for a range.
        ends: lowest and highest value of a range.
        count: number of values that a range asks for; None if the plan chooses.
        logarithmic: whether a range is spaced by an even ratio.
    """

    text: str
    keys: tuple[str, ...]
    values: tuple[tuple[str, ...], ...] = ()
    ends: tuple[str, str] | None = None
    count: int | None = None
    logarithmic: bool = False


def parse_vary(text: str) -> Vary:
    """Read the text of one ``--vary``.

    Raises:
        SceneError: it is none of the forms above.
    """
    left, equals, right = text.partition("=")
    keys = tuple(key.strip() for key in left.split(","))
    if not equals or not all(keys) or not right.strip():
        raise SceneError(f"--vary {text}: expected KEY=VALUES, such as tool.radius=2..5 mm:4")
    if len(set(keys)) < len(keys):
        raise SceneError(f"--vary {text}: expected each key once")
    low, dots, high = right.partition("..")
    if dots and split_unit(low) is not None:
        return _range(text, keys, low.strip(), high.strip())
    items = split(right)
    if not all(items):
        raise SceneError(f"--vary {text}: expected a value on each side of a comma")
    tuples = [_tuple(text, item, len(keys)) for item in items] if len(keys) > 1 else None
    if tuples is not None and all(len(values) > 1 for values in tuples):
        values = tuple(tuples)
    else:
        values = tuple((value,) * len(keys) for value in _with_unit(items))
    if len(set(values)) < len(values):
        raise SceneError(f"--vary {text}: expected each value once")
    return Vary(text, keys, values)


def split(text: str) -> list[str]:
    """Pieces between the commas that stand in neither brackets nor quotes."""
    pieces, depth, quote, start = [], 0, "", 0
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in QUOTES:
            quote = letter
        elif letter in OPENING:
            depth += 1
        elif letter in CLOSING:
            depth -= 1
        elif letter == "," and depth == 0:
            pieces.append(text[start:place].strip())
            start = place + 1
    return [*pieces, text[start:].strip()]


def split_unit(text: str) -> tuple[str, str] | None:
    """Number and unit of a quantity, the unit empty where there is none; None if it does not begin with a number."""
    match = NUMBER.match(text.strip())
    return None if match is None else (match[0], match.string[match.end() :].strip())


def _range(text: str, keys: tuple[str, ...], low: str, rest: str) -> Vary:
    high, *options = (part.strip() for part in rest.split(":"))
    ends = split_unit(low), split_unit(high)
    counts = [option for option in options if option != "log"]
    if ends[0] is None or ends[1] is None or len(counts) > 1 or options.count("log") > 1:
        raise SceneError(f"--vary {text}: expected LOW..HIGH UNIT:NUMBER, such as 2..5 mm:4, or 1e4..1e7 Pa:4:log")
    if counts and not (counts[0].isdecimal() and int(counts[0]) >= 2):
        raise SceneError(f"--vary {text}: {counts[0]!r} values; expected a whole number of at least 2")
    (number, unit), unit_of_high = ends[0], ends[1][1]
    first = f"{number} {unit or unit_of_high}".strip()
    last = f"{ends[1][0]} {unit_of_high}".strip()
    return Vary(text, keys, (), (first, last), int(counts[0]) if counts else None, "log" in options)


def _tuple(text: str, item: str, count: int) -> tuple[str, ...]:
    """Values in parentheses, one for each key; the item alone without any."""
    if not (item.startswith("(") and item.endswith(")")):
        return (item,)
    values = tuple(split(item[1:-1]))
    if len(values) != count or not all(values):
        raise SceneError(f"--vary {text}: {item}: expected {count} values, one for each key")
    return values


def _with_unit(items: list[str]) -> list[str]:
    """Values, where numbers without a unit have that of the last."""
    last = split_unit(items[-1])
    unit = last[1] if last else ""
    return [f"{item} {unit}" if unit and parse_number(item) is not None else item for item in items]
