"""Which numbers of a law a fit may change, between which bounds, and a law with other numbers in their place."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from lmfit import Parameters

from ncf_fenicsx.calibration.histories import Laws
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.kinds import marks_of, nearest
from ncf_fenicsx.laws.law import Law
from ncf_fenicsx.units import Quantity

FREE: dict[tuple[str, str], tuple[str, ...]] = {
    ("compaction", "exponential"): ("beta2", "beta3"),
    ("compaction", "power"): ("scale", "exponent"),
    ("compaction", "offset_power"): ("k", "n"),
    ("compaction", "gutowski"): ("spring", "limit"),
    ("rate", "kelly"): ("alpha1", "alpha2"),
    ("rate", "table"): ("factors",),
    ("rate", "none"): (),
    ("relaxation", "maxwell"): ("branches.share",),
    ("unloading", "permanent_set"): ("set_share", "exponent"),
    ("unloading", "pressure_set"): ("set_share", "exponent", "pressure_exponent"),
    ("shear", "constant"): ("modulus",),
    ("permeability", "gebart"): ("fibre_radius",),
    ("permeability", "kozeny_carman"): ("constant_along",),
}
"""Free by default. The others cannot be told apart from these by such tests: beta1 and beta4 of the exponential (the
base, and what the shift cancels), alpha3 and sigma_inf of Kelly's factor at a handful of speeds."""
TINY = 1e-9


def free_of(laws: Laws, more: list[str], fixed: list[str]) -> list[str]:
    """Dotted names of the numbers to fit.

    Args:
        laws: by family.
        more: names to free beside the usual ones.
        fixed: names of the usual ones that keep their values.

    Raises:
        SceneError: a law that is not fitted, or no such number.
    """
    names: list[str] = []
    for family, law in laws.items():
        if (family, law.kind) not in FREE:
            kinds = ", ".join(kind for other, kind in FREE if other == family)
            raise SceneError(f"--law {family}={law.kind}: expected one that is fitted: {kinds}")
        for name in FREE[family, law.kind]:
            names += _expanded(family, law, name)
    known = [*names, *(f"{family}.{name}" for family, law in laws.items() for name, _ in law if _is_number(law, name))]
    for option, chosen in (("--free", more), ("--fix", fixed)):
        for name in chosen:
            if name not in known:
                raise SceneError(f"{option} {name}: no such number of the laws; {nearest(name, known)}")
    return [name for name in dict.fromkeys([*names, *more]) if name not in fixed]


def _expanded(family: str, law: Law, name: str) -> list[str]:
    """Names of the entries, where a number is a list; the factor 1 of a table of rates is what it refers to."""
    if name == "branches.share":
        return [f"{family}.branches.{number}.share" for number in range(len(getattr(law, "branches", ())))]
    value = getattr(law, name)
    if isinstance(value, tuple):
        return [f"{family}.{name}.{number}" for number, entry in enumerate(value) if entry != 1.0]
    return [f"{family}.{name}"]


def _is_number(law: Law, name: str) -> bool:
    return isinstance(getattr(law, name), float)


def value_of(laws: Laws, name: str) -> float:
    """Number of a dotted name."""
    family, *path = name.split(".")
    value: Any = laws[family]
    for key in path:
        value = value[int(key)] if key.isdigit() else getattr(value, key)
    return float(value)


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


def parameters(laws: Laws, names: list[str]) -> Parameters:
    """Those numbers for lmfit, within the bounds that the laws themselves have."""
    made = Parameters()
    for name in names:
        low, high = bounds(laws, name)
        made.add(written(name), value=value_of(laws, name), min=low, max=high)
    return made


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
