"""Pint's registry of units, without Dask, which Pint loads where it is installed: it takes longer to load than Pint."""

from __future__ import annotations

import importlib
import sys
from functools import cache
from typing import TYPE_CHECKING, Any

OPTIONAL = "dask"

if TYPE_CHECKING:
    import pint


def _load() -> Any:
    if OPTIONAL in sys.modules:
        return importlib.import_module("pint")
    sys.modules[OPTIONAL] = None  # type: ignore[assignment]  # how Python notes that a module is not there
    try:
        return importlib.import_module("pint")
    finally:
        del sys.modules[OPTIONAL]


UnitError: type[Exception] = _load().errors.PintError


@cache
def registry() -> pint.UnitRegistry:
    """All units that Pint knows."""
    return _load().UnitRegistry()
