"""Constitutive laws and contact: each file is named as its table in a scene, and holds its base class and its kinds.

Importing this package makes every kind known to scenes; a law in a script of its own registers itself.
"""

from ncf_fenicsx.laws import (
    bending,
    compaction,
    contact,
    in_plane,
    permeability,
    rate,
    relaxation,
    shear,
    solid,
    unloading,
)

__all__ = [
    "bending",
    "compaction",
    "contact",
    "in_plane",
    "permeability",
    "rate",
    "relaxation",
    "shear",
    "solid",
    "unloading",
]
