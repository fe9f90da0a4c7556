"""Quantities as text at the door, SI numbers inside: ``"1 mm/min"`` becomes ``1.6667e-05``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic_core import CoreSchema, core_schema

from ncf_fenicsx.parameters.registry import UnitError, registry

SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
RAISED = "[⁻]?[⁰¹²³⁴-⁹]+"
SPACES = " \N{NO-BREAK SPACE}\N{THIN SPACE}\N{NARROW NO-BREAK SPACE}"
DIGITS = r"\d{1,3}(?:[\u2009\u202f]\d{3})+|\d+"
"""Whole number; thin spaces may set off groups of three digits, as in print."""
NUMBER = re.compile(
    rf"(?P<sign>[+\-−]?)(?P<digits>(?:{DIGITS})(?:\.\d*)?|\.\d+)"
    rf"(?:[eE](?P<exponent>[+\-−]?\d+)|\s?×\s?10(?:\^(?P<power>[+\-−]?\d+)|(?P<raised>{RAISED})))?",
    re.ASCII,
)
FACTOR = rf"[A-Za-zµμ°%]+(?:(?:\^|\*\*)?-?[0-9]|{RAISED})?"
UNIT = re.compile(rf"(?:1 ?/ ?)?{FACTOR}(?: ?[/*·] ?{FACTOR})*")
ATTACHED_POWER = re.compile(r"(?<=[A-Za-zµμ°%])(-?[0-9])")


def parse_number(text: object) -> float | None:
    """Value of one number written as text, read to the last digit; None if the text is anything else.

    Sign, digits, point and exponent, as in ``-1.5e3`` or in print, ``−1.5 × 10³``. No comma, no space between digits,
    no underscore, and no word for infinity.
    """
    match = NUMBER.fullmatch(text.strip()) if isinstance(text, str) else None
    return None if match is None else _value(match)


def _value(match: re.Match[str]) -> float:
    digits = re.sub(r"\s", "", match["digits"])
    power = match["exponent"] or match["power"] or (match["raised"] or "0").translate(SUPERSCRIPTS)
    return float(f"{match['sign']}{digits}e{power}".replace("−", "-"))


def parse_quantity(text: object, symbol: str) -> float | None:
    """Value in the SI unit ``symbol`` of one number and one unit written as text; None if the text is anything else.

    Powers in a unit are written m2, m^2, m**2 or m²; factors are joined by one of / * ·, and the first may be 1, as in
    1/m. Nothing is evaluated: what is not read whole is not read.
    """
    match = NUMBER.match(text.strip()) if isinstance(text, str) else None
    if match is None:
        return None
    unit = match.string[match.end() :].lstrip(SPACES)
    if UNIT.fullmatch(unit) is None:
        return None
    plain = ATTACHED_POWER.sub(r"**\1", re.sub(RAISED, lambda raised: str(raised[0]).translate(SUPERSCRIPTS), unit))
    try:
        value = float(registry().Quantity(_value(match), registry().parse_units(plain)).to(symbol).magnitude)
    except (UnitError, AttributeError, KeyError, ValueError, OverflowError):
        return None
    return value if math.isfinite(value) else None


def advice(text: object, symbol: str) -> str:
    """What a text that is no quantity was likely meant to be, to go after what was expected; empty without a guess."""
    if not isinstance(text, str):
        return ""
    guesses = {
        "a decimal point": re.sub(r"(?<=\d),(?=\d)", ".", text),
        "no space between digits": re.sub(r"(?<=\d)\s+(?=\d)", "", text),
        "no underscore between digits": text.replace("_", ""),
    }
    for words, guess in guesses.items():
        if guess != text and parse_quantity(guess, symbol) is not None:
            return f'; {words}: "{guess.strip()}"'
    return "; a number before the unit" if parse_quantity(f"1 {text}", symbol) is not None else ""


@dataclass(frozen=True)
class Quantity:
    """Pydantic annotation of a number with a unit.

    Args:
        symbol: SI unit as pint writes it.
        meaning: what is expected, in words, for the error line.
        example: a valid value.
        above: exclusive lower bound in SI.
        least: inclusive lower bound in SI.
        infinite: also take the word "infinite", which is None inside.
        usual: smallest and largest value in SI that a stack and its tools can be expected to have, and the unit that
            one would speak of it in.
    """

    symbol: str
    meaning: str
    example: str
    above: float = -math.inf
    least: float = -math.inf
    infinite: bool = False
    usual: tuple[float, float, str] | None = None

    def doubt(self, value: float) -> str:
        """What is doubtful about a value, shown in its natural unit; empty if nothing is."""
        if self.usual is None or value == 0 or self.usual[0] <= abs(value) <= self.usual[1]:
            return ""
        shown, low, high = (registry().Quantity(v, self.symbol).to(self.usual[2]) for v in (value, *self.usual[:2]))
        return f"{shown:.4g~C} is far outside what is usual, {low:.4g~C} to {high:.4g~C}"

    def read(self, value: object) -> float | None:
        """SI value of text with a unit.

        Raises:
            ValueError: no such quantity, or out of bounds.
        """
        if self.infinite and value == "infinite":
            return None
        number = parse_quantity(value, self.symbol)
        if number is None or number <= self.above or number < self.least:
            words = ' or "infinite"' if self.infinite else ""
            likely = advice(value, self.symbol) if number is None else ""
            raise ValueError(f'expected {self.meaning} with its unit, such as "{self.example}"{words}{likely}')
        return number

    def write(self, value: float | None) -> str:
        """Text that `read` turns back into the same number."""
        return "infinite" if value is None else f"{value!r} {self.symbol}"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write)
        )


class ShareOf(Quantity):
    """Pydantic annotation of a share written in per cent."""

    def write(self, value: float | None) -> str:
        """Text that `read` turns back into the same number."""
        return f"{100 * float(value or 0.0):.15g} %"


@dataclass(frozen=True)
class PenaltyStiffness:
    """Contact stiffness, either given (Pa/m) or as a factor on what the contacting layer resists with."""

    value: float
    is_factor: bool

    def resolve(self, natural_stiffness: float) -> float:
        """Stiffness in Pa/m, given the layer's own (compaction tangent over thickness, Pa/m)."""
        return self.value * natural_stiffness if self.is_factor else self.value


@dataclass(frozen=True)
class PenaltyField:
    """Pydantic annotation of a `PenaltyStiffness`: a bare number is a factor, text is a stiffness."""

    symbol: str = "1 or Pa/m"

    def read(self, value: object) -> PenaltyStiffness:
        """Penalty from a number or a text.

        Raises:
            ValueError: neither a positive number nor a positive stiffness per area.
        """
        if isinstance(value, PenaltyStiffness):
            return value
        is_factor = isinstance(value, int | float) and not isinstance(value, bool)
        number = float(value) if is_factor else parse_quantity(value, "Pa/m")  # type: ignore[arg-type]
        if number is None or not 0 < number < math.inf:
            likely = advice(value, "Pa/m") if number is None else ""
            raise ValueError(
                f'expected a positive factor, such as 10, or a stiffness per area, such as "1e9 Pa/m"{likely}'
            )
        return PenaltyStiffness(number, is_factor)

    def write(self, penalty: PenaltyStiffness) -> float | str:
        """What `read` turns back into the same penalty."""
        return penalty.value if penalty.is_factor else f"{penalty.value!r} Pa/m"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write)
        )


LENGTHS = (1e-7, 10.0, "mm")
STRESSES = (1e-3, 1e14, "GPa")

Length = Annotated[float, Quantity("m", "a length", "2 mm", usual=LENGTHS)]
PositiveLength = Annotated[float, Quantity("m", "a positive length", "2 mm", above=0, usual=LENGTHS)]
Thickness = Annotated[float, Quantity("m", "a positive length", "2 mm", above=0, usual=(1e-6, 0.1, "mm"))]
NonNegativeLength = Annotated[float, Quantity("m", "a length of at least 0", "0.5 mm", least=0, usual=LENGTHS)]
Clearance = Annotated[
    float, Quantity("m", "a length of at least 0 (else the tool starts in the stack)", "0 mm", least=0, usual=LENGTHS)
]
WidthOrInfinite = Annotated[
    float | None, Quantity("m", "a positive width", "30 mm", above=0, infinite=True, usual=LENGTHS)
]
PositiveForce = Annotated[float, Quantity("N", "a positive force", "10 N", above=0, usual=(1e-6, 1e6, "N"))]
PositiveTime = Annotated[float, Quantity("s", "a positive time", "0.5 s", above=0, usual=(1e-6, 1e9, "s"))]
PositiveSpeed = Annotated[float, Quantity("m/s", "a positive speed", "1 mm/min", above=0, usual=(1e-9, 10.0, "mm/min"))]
Stress = Annotated[float, Quantity("Pa", "a stress", "10 kPa", usual=STRESSES)]
PositiveStress = Annotated[float, Quantity("Pa", "a positive stress", "242 GPa", above=0, usual=STRESSES)]
Curvature = Annotated[float, Quantity("1/m", "a curvature", "5 1/m", usual=(1e-6, 1e5, "1/m"))]
LineMoment = Annotated[float, Quantity("N", "a moment per width", "0.3 N", usual=(1e-9, 1e4, "N"))]
ArealDensity = Annotated[
    float, Quantity("kg/m^2", "a positive areal density", "1425 g/m^2", above=0, usual=(1e-3, 1e2, "g/m^2"))
]
Density = Annotated[
    float, Quantity("kg/m^3", "a positive density", "1.79e6 g/m^3", above=0, usual=(10.0, 3e4, "g/cm^3"))
]
Acceleration = Annotated[
    float, Quantity("m/s^2", "an acceleration of at least 0", "9.81 m/s^2", least=0, usual=(1e-3, 1e3, "m/s^2"))
]
Penalty = Annotated[PenaltyStiffness, PenaltyField()]
PositiveShare = Annotated[float, ShareOf("dimensionless", "a positive share in per cent", "1 %", above=0)]
PositiveMemory = Annotated[
    float, Quantity("byte", "a positive amount of memory", "4 GB", above=0, usual=(1e7, 1e14, "GB"))
]
