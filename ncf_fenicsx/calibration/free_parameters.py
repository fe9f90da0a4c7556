"""Which numbers of a law a fit may change, between which bounds, and a law with other numbers in their place."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from lmfit import Parameters
from numpy.typing import NDArray

from ncf_fenicsx.calibration.histories import Laws
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.law import Law
from ncf_fenicsx.laws.monotone_cubic import Tabulated
from ncf_fenicsx.parameters.kinds import marks_of, nearest
from ncf_fenicsx.parameters.units import Quantity

Floats = NDArray[np.float64]
TINY = 1e-9
LEAST_GAIN = 1e-6
"""Gain from entry to entry of a table that is fitted, over the one to begin with."""
ANCHORS = (0.0, 1.0)
"""Entries of tables that stay: no pressure at Vf0, and the factor of the speed that the others refer to."""


def fitted_of(law: Law) -> tuple[str, ...]:
    """Numbers that a fit frees: those that the law names, else all it has."""
    return law.fitted if law.fitted is not None else tuple(name for name, _ in law if _is_number(law, name))


def free_of(laws: Laws, more: list[str], fixed: list[str]) -> list[str]:
    """Dotted names of the numbers to fit.

    Args:
        laws: by family.
        more: names to free beside the usual ones.
        fixed: names of the usual ones that keep their values.

    Raises:
        SceneError: no such number.
    """
    names = [found for family, law in laws.items() for name in fitted_of(law) for found in _expanded(family, law, name)]
    known = [*names, *(f"{family}.{name}" for family, law in laws.items() for name, _ in law if _is_number(law, name))]
    for option, chosen in (("--free", more), ("--fix", fixed)):
        for name in chosen:
            if name not in known:
                raise SceneError(f"{option} {name}: no such number of the laws; {nearest(name, known)}")
    return [name for name in dict.fromkeys([*names, *more]) if name not in fixed]


def _expanded(family: str, law: Law, name: str) -> list[str]:
    """Names of the entries, where a number is a list, but for those that the others refer to."""
    name, _, inner = name.partition(".")
    value = getattr(law, name)
    if not isinstance(value, tuple):
        return [f"{family}.{name}"]
    entries = [f"{family}.{name}.{number}" for number, entry in enumerate(value) if entry not in ANCHORS]
    return [f"{entry}.{inner}" for entry in entries] if inner else entries


def _is_number(law: Law, name: str) -> bool:
    return isinstance(getattr(law, name), float)


def value_of(laws: Laws, name: str) -> float:
    """Number of a dotted name."""
    family, *path = name.split(".")
    value: Any = laws[family]
    for key in path:
        value = value[int(key)] if key.isdigit() else getattr(value, key)
    return float(value)


def named(names: list[str], values: Floats) -> dict[str, float]:
    """Values by their names."""
    return {name: float(value) for name, value in zip(names, values, strict=True)}


def with_values(laws: Laws, values: Mapping[str, float]) -> Laws:
    """The laws with other numbers."""
    changed = dict(laws)
    for name, value in values.items():
        family, *path = name.split(".")
        if family in changed:
            changed[family] = _with(changed[family], path, float(value))
    return changed


def _with(part: Any, path: list[str], value: float) -> Any:
    if not path:
        return value
    key, rest = path[0], path[1:]
    if isinstance(part, tuple):
        return tuple(_with(item, rest, value) if number == int(key) else item for number, item in enumerate(part))
    return part.model_copy(update={key: _with(getattr(part, key), rest, value)})


@dataclass(frozen=True)
class Unknowns:
    """What least squares varies in place of some numbers: numbers = base + slopes @ unknowns.

    Attributes:
        names: of the numbers.
        base: see above.
        slopes: see above.
        begin: unknowns to begin from.
        low: their least values.
        high: their largest values.
    """

    names: list[str]
    base: Floats
    slopes: Floats
    begin: Floats
    low: Floats
    high: Floats

    def named(self, unknowns: Floats) -> dict[str, float]:
        """The numbers."""
        return named(self.names, self.base + self.slopes @ unknowns)

    def with_another(self, name: str, begin: float) -> Unknowns:
        """A number more, which is an unknown itself and without bounds."""
        size = len(self.names)
        slopes = np.eye(size + 1)
        slopes[:size, :size] = self.slopes
        base, begins = np.append(self.base, 0.0), np.append(self.begin, begin)
        low, high = np.append(self.low, -np.inf), np.append(self.high, np.inf)
        return Unknowns([*self.names, name], base, slopes, begins, low, high)

    def parameters(self) -> Parameters:
        """For lmfit."""
        made = Parameters()
        for name, value, low, high in zip(self.names, self.begin, self.low, self.high, strict=True):
            made.add(written(name), value=value, min=low, max=high)
        return made


def unknowns(laws: Laws, names: list[str]) -> Unknowns:
    """Unknowns of some numbers, within the bounds that the laws have.

    Of the entries of a table they are the gains from one to the next, which are positive: so it ascends whatever they
    are. Entries before one that stays are counted down from it.
    """
    base, slopes = np.zeros(len(names)), np.eye(len(names))
    low, high = (np.array(ends) for ends in zip(*(bounds(laws, name) for name in names), strict=True))
    counted = [(place, *found) for place, name in enumerate(names) if (found := _neighbour(laws, name, names))]
    ups, downs = ([entry for entry in counted if entry[2] == sign] for sign in (1, -1))
    for place, other, sign in [*ups, *reversed(downs)]:
        slopes[place] *= sign
        if other in names:
            slopes[place] += slopes[names.index(other)]
            base[place] = base[names.index(other)]
        else:
            base[place] = value_of(laws, other)
    values = np.array([value_of(laws, name) for name in names])
    begin = np.asarray(np.linalg.solve(slopes, values - base), dtype=np.float64)
    gains = [place for place, _, _ in counted]
    low[gains], high[gains] = LEAST_GAIN * begin[gains], np.inf
    return Unknowns(names, base, slopes, begin, low, high)


def _neighbour(laws: Laws, name: str, names: list[str]) -> tuple[str, int] | None:
    """Entry of a table that another counts up (1) or down (-1) from; None of a number that counts from none."""
    family, key, *place = name.split(".")
    law = laws[family]
    if not isinstance(law, Tabulated) or key not in law.columns:
        return None
    held = [n for n in range(len(getattr(law, key))) if f"{family}.{key}.{n}" not in names]
    sign = -1 if held and min(held) > int(place[0]) else 1
    other = int(place[0]) - sign
    return (f"{family}.{key}.{other}", sign) if other >= 0 else None


def positive_parameters(name: str, values: list[float]) -> Parameters:
    """Numbers above 0 for lmfit, numbered."""
    made = Parameters()
    for number, value in enumerate(values):
        made.add(f"{name}_{number}", value=value, min=TINY)
    return made


def bounds(laws: Laws, name: str) -> tuple[float, float]:
    """Smallest and largest value that a law takes."""
    family, *path = name.split(".")
    part: Any = laws[family]
    field = type(part).model_fields[path[0]]
    if path[0] == "branches":
        field = type(part.branches[0]).model_fields[path[-1]]
    low, high = -np.inf, np.inf
    for mark in marks_of(field)[0]:
        if isinstance(mark, Quantity):
            low = max(low, mark.above, mark.least)
        lows = [getattr(mark, key, None) for key in ("gt", "ge")]
        highs = [getattr(mark, key, None) for key in ("lt", "le")]
        low = max([low, *(float(bound) for bound in lows if bound is not None)])
        high = min([high, *(float(bound) for bound in highs if bound is not None)])
    return low + TINY if np.isfinite(low) else low, high - TINY if np.isfinite(high) else high


def written(name: str) -> str:
    """Name as lmfit takes it."""
    return re.sub(r"\W", "__", name)
