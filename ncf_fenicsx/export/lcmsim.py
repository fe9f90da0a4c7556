"""Mesh and part table for LCMsim, which fills thin parts with resin on triangles of their mid-surface.

The part table has what LCMsim 3 asks for. Each column of cells through the stack becomes two triangles. Columns of like
Vf make a part, since LCMsim holds a part's number in eight bits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.export.deformed import Deformed, axes
from ncf_fenicsx.export.files import Floats, Integers, Writer, classes, rows_of, text_writer
from ncf_fenicsx.export.tables import table_writer
from ncf_fenicsx.grid_lines import places

MOST_PARTS = 100
FIELD = 8
"""Letters of a number in the mesh file."""
ISOTROPIC = 1 - 1e-6
"""Ratio of the permeabilities in the plane from which on there is no direction of the larger one."""
NO_MORE = {"porosity_noise": 0.0, "permeability_noise": 0.0, "p_1": 0.9e5, "p_2": 1e5, "n_CK": 0.0}
"""Columns of effects that a table from a dry state knows nothing of: scatter, and compaction under vacuum."""


@dataclass(frozen=True)
class Columns:
    """The columns of cells through a stack, seen as a shell.

    Attributes:
        points: of the mid-surface in m, shape (points, 3).
        quadrangles: points of each column, anticlockwise seen from above, shape (columns, 4).
        members: cells of each column from the bottom up, shape (columns, cells through the stack).
    """

    points: Floats
    quadrangles: Integers
    members: Integers

    @classmethod
    def of(cls, deformed: Deformed) -> Columns:
        """Find the columns: cells, and nodes, that lay above each other in the undeformed stack.

        Raises:
            SceneError: layers have different meshes, so that there are no columns.
        """
        undeformed, cells = deformed.layers.points, deformed.cells
        extent = float(np.ptp(undeformed[:, :2], axis=0).max())
        middle = undeformed[cells].mean(axis=1)
        column = places(middle[:, :2], extent)
        counts = np.bincount(column)
        if (counts != counts[0]).any():
            raise SceneError("--to lcmsim: layers have different meshes; expected one of columns through the stack")
        members = np.lexsort([middle[:, 2], column]).reshape(-1, counts[0])
        place = places(undeformed[:, :2], extent)
        order = np.lexsort([undeformed[:, 2], place])
        first = np.flatnonzero(np.diff(place[order], prepend=-1))
        last = np.append(first[1:], len(order)) - 1
        points = (deformed.points[order[first]] + deformed.points[order[last]]) / 2
        return cls(points, place[cells[members[:, 0], :4]], members)

    @property
    def areas(self) -> Floats:
        """Of the columns in m2, shape (columns,)."""
        corners = self.points[self.quadrangles]
        across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        return np.asarray(np.linalg.norm(across, axis=1) / 2)


def lcmsim_files(deformed: Deformed) -> dict[str, Writer]:
    """``mesh.bdf`` and ``part_description.csv``.

    Raises:
        SceneError: the results have no permeability, or layers have different meshes.
    """
    deformed.need_permeability("lcmsim")
    columns = Columns.of(deformed)
    by_column = _through_columns(deformed, columns)
    part = classes(by_column["porosity"], MOST_PARTS)
    return {
        "mesh.bdf": text_writer(_mesh(columns, part)),
        "part_description.csv": table_writer(_parts(columns, by_column, part)),
    }


def _through_columns(deformed: Deformed, columns: Columns) -> dict[str, Floats]:
    """Thickness, porosity, permeability in the plane (tensor along x, y, z) and across, by column.

    Layers lie side by side to a flow in the plane, and one behind the other to a flow across. Gaps are not counted.
    """
    fields = {name: values[columns.members] for name, values in deformed.cell_fields.items()}
    first, second = (axis[columns.members] for axis in axes(deformed.cell_fields))
    thickness = fields["thickness"]
    total = thickness.sum(axis=1)
    tensor = sum(
        np.einsum("ij,ijk,ijl->ikl", thickness * fields[f"permeability_{number}"], axis, axis)
        for number, axis in ((1, first), (2, second))
    )
    return {
        "thickness": total,
        "porosity": (thickness * fields["porosity"]).sum(axis=1) / total,
        "tensor": tensor / total[:, None, None],
        "across": total / (thickness / fields["permeability_3"]).sum(axis=1),
        "axis": first.mean(axis=1),
    }


def _parts(columns: Columns, by_column: dict[str, Floats], part: Integers) -> dict[str, list[object]]:
    """The part table: a row for each part, with means by area."""
    rows = []
    for number in range(int(part.max()) + 1):
        chosen = part == number
        weights = columns.areas[chosen] / columns.areas[chosen].sum()
        mean = {name: np.tensordot(weights, values[chosen], axes=1) for name, values in by_column.items()}
        rows.append(_part(number + 1, mean))
    return {name: [row[name] for row in rows] for name in rows[0]}


def _part(number: int, mean: dict[str, Floats]) -> dict[str, object]:
    sizes, directions = np.linalg.eigh(mean["tensor"])
    alpha, direction = sizes[1] / sizes[2], directions[:, 2]
    if alpha > ISOTROPIC:
        direction = mean["axis"]
    direction = direction * (1 if direction[np.abs(direction).argmax()] > 0 else -1)
    porosity, permeability, across = float(mean["porosity"]), float(sizes[2]), float(mean["across"])
    return {
        "name": f"part_{number}",
        "type": "base",
        "part_id": number,
        "thickness": float(mean["thickness"]),
        "porosity": porosity,
        "permeability": permeability,
        "alpha": float(alpha),
        **{f"refdir{axis + 1}": float(direction[axis]) for axis in range(3)},
        "porosity_1": porosity,
        "porosity_2": porosity,
        "permeability_Z": across,
        **NO_MORE,
        "thickness_DM": 0.0,
        "porosity_DM": porosity,
        "permeability_DM": permeability,
        "permeability_DM_Z": across,
    }


def _mesh(columns: Columns, part: Integers) -> list[str]:
    """Nastran's cards GRID and CTRIA3, as gmsh writes them."""
    lines = ["$ mid-surface in m"]
    for number, point in enumerate(rows_of(columns.points), 1):
        lines.append(f"{'GRID':<8}{number:<8}{'':8}" + "".join(f"{card_number(value):<8}" for value in point))
    for number, corners in enumerate(rows_of(1 + columns.quadrangles)):
        for half, chosen in enumerate(((0, 1, 2), (0, 2, 3))):
            nodes = "".join(f"{corners[one]:<8}" for one in chosen)
            lines.append(f"{'CTRIA3':<8}{2 * number + half + 1:<8}{part[number] + 1:<8}{nodes}".rstrip())
    return [*lines, "ENDDATA"]


def card_number(value: float) -> str:
    """A number as near as it can be written in the letters of a field."""
    texts = [f"{value:.{digits}f}".replace("0.", ".", 1) for digits in range(1, FIELD)]
    for digits in range(FIELD):
        mantissa, power = f"{value:.{digits}e}".split("e")
        texts.append(f"{mantissa}E{int(power)}")
    fitting = [text for text in texts if len(text) <= FIELD and text.strip("-") != "."]
    return min(fitting, key=lambda text: (abs(float(text) - value), len(text)))
