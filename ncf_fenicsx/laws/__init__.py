"""Constitutive laws, one file each. Importing this package makes every file in it known to scenes."""

import importlib
import pkgutil

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
