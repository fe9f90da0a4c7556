"""Quantities as text at the door, SI numbers inside: ``"1 mm/min"`` becomes ``1.6667e-05``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import pint
from pydantic_core import CoreSchema, core_schema


@cache
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


def parse_quantity(text: object, symbol: str) -> float | None:
    """Value in the SI unit ``symbol`` of a quantity written as text; None if the text is no such quantity."""
    if not isinstance(text, str):
        return None
    try:
        value = float(_registry().Quantity(text).to(symbol).magnitude)
    except Exception:  # pint hands on whatever its tokeniser raises for malformed text
        return None
    return value if math.isfinite(value) else None


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
    """

    symbol: str
    meaning: str
    example: str
    above: float = -math.inf
    least: float = -math.inf
    infinite: bool = False

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
            raise ValueError(f'expected {self.meaning} with its unit, such as "{self.example}"{words}')
        return number

    def write(self, value: float | None) -> str:
        """Text that `read` turns back into the same number."""
        return "infinite" if value is None else f"{value!r} {self.symbol}"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write)
        )


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
            raise ValueError('expected a positive factor, such as 10, or a stiffness per area, such as "1e9 Pa/m"')
        return PenaltyStiffness(number, is_factor)

    def write(self, penalty: PenaltyStiffness) -> float | str:
        """What `read` turns back into the same penalty."""
        return penalty.value if penalty.is_factor else f"{penalty.value!r} Pa/m"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(
            self.read, serialization=core_schema.plain_serializer_function_ser_schema(self.write)
        )


Length = Annotated[float, Quantity("m", "a length", "2 mm")]
PositiveLength = Annotated[float, Quantity("m", "a positive length", "2 mm", above=0)]
NonNegativeLength = Annotated[float, Quantity("m", "a length of at least 0", "0.5 mm", least=0)]
Clearance = Annotated[
    float, Quantity("m", "a length of at least 0 (else the tool starts in the stack)", "0 mm", least=0)
]
WidthOrInfinite = Annotated[float | None, Quantity("m", "a positive width", "30 mm", above=0, infinite=True)]
PositiveForce = Annotated[float, Quantity("N", "a positive force", "10 N", above=0)]
PositiveTime = Annotated[float, Quantity("s", "a positive time", "0.5 s", above=0)]
PositiveSpeed = Annotated[float, Quantity("m/s", "a positive speed", "1 mm/min", above=0)]
Stress = Annotated[float, Quantity("Pa", "a stress", "10 kPa")]
PositiveStress = Annotated[float, Quantity("Pa", "a positive stress", "242 GPa", above=0)]
ArealDensity = Annotated[float, Quantity("kg/m^2", "a positive areal density", "1425 g/m^2", above=0)]
Density = Annotated[float, Quantity("kg/m^3", "a positive density", "1.79e6 g/m^3", above=0)]
Acceleration = Annotated[float, Quantity("m/s^2", "an acceleration of at least 0", "9.81 m/s^2", least=0)]
Penalty = Annotated[PenaltyStiffness, PenaltyField()]
