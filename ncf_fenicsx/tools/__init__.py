"""Rigid tools and moulds, and the paths that tools follow.

Importing this package makes every kind known to scenes; a tool in a script of its own registers itself.
"""

from ncf_fenicsx.tools import (
    cylinder,
    moulds,
    path,
    plate,
    presser_foot,
    profile,
    rigid_surface,
    sphere,
    start,
)

__all__ = [
    "cylinder",
    "moulds",
    "path",
    "plate",
    "presser_foot",
    "profile",
    "rigid_surface",
    "sphere",
    "start",
]
