"""Constitutive laws and contact: what a scene names under ``[laws]``, one file for each table.

Importing this package makes every kind known to scenes; a law in a script of its own registers itself.
"""

from ncf_fenicsx.laws import (
    as_printed,
    constant_shear,
    contact,
    exponential,
    fibre_families,
    gebart,
    growing_shear,
    gutowski,
    kelly_rate,
    kozeny_carman,
    maxwell,
    mid_plane,
    neo_hookean,
    offset_power,
    permanent_set,
    power,
    solid_logarithmic,
    solid_split,
    table,
)

__all__ = [
    "as_printed",
    "constant_shear",
    "contact",
    "exponential",
    "fibre_families",
    "gebart",
    "growing_shear",
    "gutowski",
    "kelly_rate",
    "kozeny_carman",
    "maxwell",
    "mid_plane",
    "neo_hookean",
    "offset_power",
    "permanent_set",
    "power",
    "solid_logarithmic",
    "solid_split",
    "table",
]
