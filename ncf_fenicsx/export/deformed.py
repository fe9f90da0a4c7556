"""The deformed stack of one step, as other programs want it: places, fields, thickness, porosity, permeability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.in_plane import FibreFamilies
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.surfaces import Layers
from ncf_fenicsx.scene import Scene

Floats = NDArray[np.float64]

ENDS = np.array([[[1, 2, 5, 6], [0, 3, 4, 7]], [[2, 3, 6, 7], [0, 1, 4, 5]], [[4, 5, 6, 7], [0, 1, 2, 3]]])
"""Corners at either end of each axis of a hexahedron in VTK's order, the third axis across the layer."""


@dataclass(frozen=True)
class Deformed:
    """A stack at one step, in SI.

    Attributes:
        layers: mesh and fields of that step, as a results folder has them.
        scene: the case.
    """

    layers: Layers
    scene: Scene

    @classmethod
    def read(cls, results: Results, time: float | None) -> Deformed:
        """Read the step that was written nearest to a time in s; the last one unless given.

        Raises:
            SceneError: the folder has no field files, or one of them cannot be read.
        """
        if not results.snapshots:
            raise SceneError(f"{results.folder}: has no fields.pvd; expected results with field files")
        times = np.array([at for at, _ in results.snapshots])
        chosen = len(times) - 1 if time is None else int(np.abs(times - time).argmin())
        try:
            return cls(Layers.read(results, [chosen], np.float64), results.scene)
        except Exception as error:  # of meshio, XML and the system: all say that the file is not whole
            name = results.snapshots[chosen][1]
            raise SceneError(f"{results.folder / name}: cannot be read: {error}; expected a field file") from error

    @property
    def time(self) -> float:
        """Of the step in s."""
        return float(self.layers.times[0])

    @property
    def displacement(self) -> Floats:
        """Of the nodes in m, shape (nodes, 3)."""
        return np.column_stack([self.layers.nodes[f"displacement_{axis}"][0] for axis in "xyz"])

    @property
    def points(self) -> Floats:
        """Deformed nodes in m, shape (nodes, 3)."""
        return self.layers.points + self.displacement

    @property
    def cells(self) -> NDArray[np.int64]:
        """Nodes of the hexahedra in VTK's order, which Abaqus's C3D8 has too, shape (cells, 8)."""
        return self.layers.cells

    @property
    def node_fields(self) -> dict[str, Floats]:
        """Fields at nodes but for the displacement, by name, shape (nodes,)."""
        fields = {name: values[0] for name, values in self.layers.nodes.items()}
        return {name: values for name, values in fields.items() if not name.startswith("displacement_")}

    @property
    def cell_fields(self) -> dict[str, Floats]:
        """Fields of cells by name, shape (cells,): those of the results, and what follows from them.

        ``thickness`` and ``reference_thickness`` in m are those of the cell across its layer, deformed and not.
        ``permeability_1`` to ``_3`` in m2 are those of the layer along its axes: 1 and 2 in its plane, 3 across. Axes 1
        and 3 are given by their parts along x, y and z, as ``axis_1_x``; axis 2 is square to both. ``porosity`` is
        1 - Vf.
        """
        fields = {name: values[0] for name, values in self.layers.by_cell.items()}
        fields |= {
            "thickness": _thickness(self._edges(self.points)),
            "reference_thickness": _thickness(self._edges(self.layers.points)),
        }
        if "volume_fraction" in fields:
            fields["porosity"] = 1 - fields["volume_fraction"]
        if "permeability_along" in fields:
            fields |= self._permeabilities(fields["permeability_along"], fields["permeability_across"])
        return fields

    def need_permeability(self, what: str) -> None:
        """Raise a SceneError where the results have no permeability, which a format is made of."""
        if "permeability_along" not in self.layers.by_cell:
            expected = "expected results of a scene with [output.permeability]"
            raise SceneError(f"--to {what}: the results have no permeability; {expected}")

    def _edges(self, points: Floats) -> Floats:
        """Vectors along the three axes of each cell through its middle in m, shape (cells, axis, 3)."""
        ends = points[self.cells[:, ENDS]].mean(axis=3)
        return np.asarray(ends[:, :, 0] - ends[:, :, 1])

    def _permeabilities(self, along: Floats, across: Floats) -> dict[str, Floats]:
        """Of the layers: mean over the plies, which lie side by side to a flow in the plane."""
        shares, angles = fibre_axes(self.scene)
        share, angle = shares[self.layers.layer - 1], angles[self.layers.layer - 1]
        axis = np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
        edges = self._edges(self.points)
        gradient = np.linalg.solve(self._edges(self.layers.points), edges)  # F transposed
        turned = unit(np.einsum("ij,ijk->ik", axis, gradient))
        normal = unit(np.cross(edges[:, 0], edges[:, 1]))
        return {
            "permeability_1": share * along + (1 - share) * across,
            "permeability_2": (1 - share) * along + share * across,
            "permeability_3": across,
            **{f"axis_1_{name}": turned[:, number] for number, name in enumerate("xyz")},
            **{f"axis_3_{name}": normal[:, number] for number, name in enumerate("xyz")},
        }


def axes(fields: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Axes 1 and 2 of all cells from their fields, unit vectors of shape (cells, 3)."""
    first, third = (np.column_stack([fields[f"axis_{number}_{name}"] for name in "xyz"]) for number in (1, 3))
    return first, np.asarray(np.cross(third, first))


def unit(vectors: NDArray[Any]) -> Floats:
    """Vectors of length 1 along some vectors, shape (vectors, 3)."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def _thickness(edges: Floats) -> Floats:
    """Volume over area of the mid-plane, shape (cells,)."""
    area = np.cross(edges[:, 0], edges[:, 1])
    return np.asarray(np.einsum("ij,ij->i", area, edges[:, 2]) / np.linalg.norm(area, axis=1))


def fibre_axes(scene: Scene) -> tuple[Floats, Floats]:
    """Share of the fibres along the axis that most lie along, and its angle from x in radians, both for each layer.

    The axes are those of the mean of a a^T over the directions a of the plies. A law without directions in its plane
    stands for fibres in all of them: one half, along x.
    """
    law: Any = scene.laws.in_plane
    count = scene.stack.layers
    if not isinstance(law, FibreFamilies):
        return np.full(count, 0.5), np.zeros(count)
    shares, angles = np.empty(count), np.empty(count)
    for number in range(count):
        plies = law.plies[number] if isinstance(law.plies[0], tuple) else law.plies
        radians = np.radians(np.array(plies, dtype=float))
        twice = np.exp(2j * radians).mean()
        shares[number] = (1 + abs(twice)) / 2
        angles[number] = np.angle(twice) / 2 if abs(twice) > 1e-12 else 0.0
    return shares, angles
