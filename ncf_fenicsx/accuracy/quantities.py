"""The numbers that a sequence of runs bounds the error of, read from the results folder of each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import Bonded

FIELD = "vf_field"
"""Name of the one quantity that is a field."""


@dataclass(frozen=True)
class Quantity:
    """What a quantity is.

    Attributes:
        title: in words.
        unit: that it is shown in.
        factor: from SI to that unit.
        column: of the history that it is the largest of, for the progress line; "" for none.
    """

    title: str
    unit: str = ""
    factor: float = 1.0
    column: str = ""


QUANTITIES = {
    "force": Quantity("largest force", "N", 1.0, "tool_force"),
    "vf": Quantity("largest Vf", column="vf_max"),
    FIELD: Quantity("field of Vf at the end, root mean square change"),
    "void_volume": Quantity("largest volume of voids", "mm3", 1e9),
    "wrinkle_height": Quantity("height of the highest wrinkle", "mm", 1e3),
}


def check_quantities(scene: Scene, names: tuple[str, ...]) -> None:
    """Whether a scene has these quantities.

    Raises:
        SceneError: it has not; it names which it has.
    """
    has = quantities_of(scene)
    for name in names:
        if not has[name]:
            expected = "expected one that this scene has: " + ", ".join(other for other in has if has[other])
            raise SceneError(f"accuracy.quantities = {name!r}: {expected}")


def quantities_of(scene: Scene) -> dict[str, bool]:
    """Whether a scene has each of the quantities."""
    parts = any(not isinstance(way, Bonded) for way in scene.interfaces[: scene.stack.layers - 1])
    fibres = scene.laws.solid is None
    one_mesh = len(set(scene.stack.divisions_by_layer)) == len(set(scene.stack.elements_through)) == 1
    return {
        "force": bool(scene.tool),
        "vf": fibres,
        "void_volume": parts,
        "wrinkle_height": True,
        FIELD: fibres and one_mesh,
    }


def measure(folder: Path, name: str) -> float:
    """A quantity of a run in SI; of the field, its root mean square change."""
    results = Results.read(folder)
    if name == "force":
        return float(max(results.history[column].max() for column in results.tool_columns("tool_force")))
    if name == "vf":
        return float(results.history["vf_max"].max())
    if name == "void_volume":
        voids = [results.history[column] for column in results.interface_columns("void_volume")]
        return float(np.sum(voids, axis=0).max())
    return float(max(np.nanmax(results.history[column]) for column in results.layer_columns("wrinkle_height")))
