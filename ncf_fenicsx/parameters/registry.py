"""Pint's registry of units, without Dask, which Pint loads where it is installed: it takes longer to load than Pint.

In a program that loads this package before Pint and Dask, Pint takes arrays of Dask for plain objects.
"""

from __future__ import annotations

import importlib
import sys
from functools import cache
from typing import TYPE_CHECKING, Any

OPTIONAL = "dask"


def _load() -> Any:
    if OPTIONAL in sys.modules or "pint" in sys.modules:
        return importlib.import_module("pint")
    sys.modules[OPTIONAL] = None  # type: ignore[assignment]  # how Python notes that a module is not there
    try:
        return importlib.import_module("pint")
    finally:
        del sys.modules[OPTIONAL]


if TYPE_CHECKING:
    import pint
else:
    pint = _load()

UnitError: type[Exception] = pint.errors.PintError


@cache
def registry() -> pint.UnitRegistry:
    """All units that Pint knows."""
    return pint.UnitRegistry()
