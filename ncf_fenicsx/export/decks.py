"""Input decks for Abaqus and CalculiX: the deformed mesh, with its fields, in SI."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ncf_fenicsx.export.deformed import Deformed, axes
from ncf_fenicsx.export.files import Floats, Integers, Writer, classes, rows_of, text_writer

CLASSES = 50
"""Classes of Vf in each layer, each with a material of its own, in a deck for CalculiX."""
SQUARE_MICROMETRES = 1e12
"""Square micrometres in a square metre: CalculiX drops conductivities as small as permeabilities in m2."""
STATES = ("volume_fraction", "thickness", "reference_thickness", "permeability_1", "permeability_2", "permeability_3")


def abaqus_files(deformed: Deformed) -> dict[str, Writer]:
    """``deformed.inp``: to be included in a model; layers as element sets, fields as initial states of the elements."""
    fields = deformed.cell_fields
    names = [name for name in STATES if name in fields]
    lines = [*_mesh(deformed), *_layer_sets(deformed)]
    if "axis_1_x" in fields:
        lines += _orientations(fields)
    lines += [f"** states: {', '.join(names)}", "*INITIAL CONDITIONS, TYPE=SOLUTION"]
    values = np.column_stack([fields[name] for name in names])
    lines += [f"{number}, {_numbers(row)}" for number, row in enumerate(rows_of(values), 1)]
    return {"deformed.inp": text_writer(lines)}


def calculix_files(deformed: Deformed) -> dict[str, Writer]:
    """``darcy.inp``: slow flow of resin from the lowest to the highest x, which CalculiX solves as heat.

    Temperature is pressure, 1 Pa to 0 Pa, conductivity is permeability in square micrometres, and the flow is
    that of a fluid of 1 Pa s.

    Raises:
        SceneError: the results have no permeability.
    """
    deformed.need_permeability("calculix")
    fields, layer = deformed.cell_fields, deformed.layers.layer
    lines = [*_mesh(deformed), *_layer_sets(deformed)]
    for number in range(1, deformed.scene.stack.layers + 1):
        cells = np.flatnonzero(layer == number)
        group = classes(fields["volume_fraction"][cells], CLASSES)
        for one in range(group.max() + 1):
            lines += _material(f"L{number}_{one + 1}", cells[group == one], fields)
    lines += ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 0."]
    lines += ["*STEP", "*HEAT TRANSFER, STEADY STATE", "*BOUNDARY", "X_MIN, 11, 11, 1.", "X_MAX, 11, 11, 0."]
    lines += ["*NODE FILE", "NT", "*NODE PRINT, NSET=ALL", "NT", "*END STEP"]
    return {"darcy.inp": text_writer(lines)}


def _mesh(deformed: Deformed) -> list[str]:
    title = " ".join(deformed.scene.title.split()).encode("ascii", "replace").decode()
    lines = ["*HEADING", f"{title}, deformed at {deformed.time:.9g} s, in m", "*NODE, NSET=ALL"]
    lines += [f"{number}, {_numbers(point)}" for number, point in enumerate(rows_of(deformed.points), 1)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=STACK"]
    for number, cell in enumerate(rows_of(1 + deformed.cells), 1):
        lines.append(f"{number}, {', '.join(map(str, cell))}")
    undeformed = deformed.layers.points
    for name, axis, side in (("X", 0, "MIN"), ("X", 0, "MAX"), ("Y", 1, "MIN"), ("Y", 1, "MAX")):
        places = undeformed[:, axis]
        end = places.min() if side == "MIN" else places.max()
        at = np.flatnonzero(np.abs(places - end) <= 1e-9 * np.ptp(places))
        lines += _set("NSET", f"{name}_{side}", at)
    count = deformed.scene.stack.layers
    lines += _set("NSET", "BOTTOM", deformed.layers.face_nodes(1, False))
    return lines + _set("NSET", "TOP", deformed.layers.face_nodes(count, True))


def _layer_sets(deformed: Deformed) -> list[str]:
    lines: list[str] = []
    for number in range(1, deformed.scene.stack.layers + 1):
        lines += _set("ELSET", f"LAYER_{number}", np.flatnonzero(deformed.layers.layer == number))
    return lines


def _orientations(fields: dict[str, Floats]) -> list[str]:
    """Axis 1 of each element and one square to it in the layer, as a distribution."""
    first, second = axes(fields)
    lines = ["*DISTRIBUTION TABLE, NAME=AXES_TABLE", "COORD3D, COORD3D"]
    lines += ["*DISTRIBUTION, NAME=AXES, LOCATION=ELEMENT, TABLE=AXES_TABLE", ", 1., 0., 0., 0., 1., 0."]
    rows = np.column_stack([first, second])
    lines += [f"{number}, {_numbers(row)}" for number, row in enumerate(rows_of(rows), 1)]
    return [*lines, "*ORIENTATION, NAME=FABRIC", "AXES", "3, 0."]


def _material(name: str, cells: Integers, fields: dict[str, Floats]) -> list[str]:
    """A class of elements with its mean permeabilities along its mean axes."""
    first, second = (axis[cells].mean(axis=0) for axis in axes(fields))
    permeabilities = [SQUARE_MICROMETRES * fields[f"permeability_{axis}"][cells].mean() for axis in (1, 2, 3)]
    return [
        *_set("ELSET", name, cells),
        f"*ORIENTATION, NAME=O{name}",
        _numbers([*first, *second]),
        f"*MATERIAL, NAME=M{name}",
        "*CONDUCTIVITY, TYPE=ORTHO",
        _numbers(permeabilities),
        f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}, ORIENTATION=O{name}",
    ]


def _set(kind: str, name: str, members: Integers) -> list[str]:
    numbers: list[int] = list(1 + members)
    rows = [", ".join(map(str, numbers[start : start + 16])) for start in range(0, len(numbers), 16)]
    return [f"*{kind}, {kind}={name}", *(f"{row}," for row in rows[:-1]), *rows[-1:]]


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.12g}" for value in values)
