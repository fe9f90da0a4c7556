"""Rigid tools and moulds, and the paths that tools follow.

Importing this package makes every kind known to scenes; a tool in a script of its own registers itself.
"""

from ncf_fenicsx.tools import (
    cylinder,
    mould_cylinder,
    mould_plate,
    mould_sphere,
    plate,
    presser_foot,
    profile,
    sphere,
)

__all__ = [
    "cylinder",
    "mould_cylinder",
    "mould_plate",
    "mould_sphere",
    "plate",
    "presser_foot",
    "profile",
    "sphere",
]
