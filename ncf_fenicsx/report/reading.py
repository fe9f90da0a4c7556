"""What a results folder holds, read back."""

from __future__ import annotations

import json
import tomllib
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self
from xml.etree import ElementTree

import meshio
import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.grid_lines import grid_lines
from ncf_fenicsx.output.results_folder import ERROR_BANDS
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene

VARIES = 0.1
"""Difference of heights at one undeformed x, over the largest lift, from which on a wrinkle varies along y."""


def read_history(path: Path) -> Any:
    """Columns of a ``history.csv`` by name, each a vector; without a last row that is just being written."""
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    whole = [line for line in lines if line.endswith("\n")]
    return np.atleast_1d(np.genfromtxt(whole, delimiter=",", names=True))


def read_rows(folder: Path) -> list[dict[str, float]]:
    """Rows of the ``history.csv`` of a results folder."""
    columns = read_history(folder / "history.csv")
    return [dict(zip(columns.dtype.names, map(float, row), strict=True)) for row in columns]


def read_record(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a results folder."""
    return dict(json.loads((folder / "run.json").read_text(encoding="utf-8")))


def read_snapshots(folder: Path) -> list[tuple[float, str]]:
    """Times in s and names of the field files of a results folder."""
    entries = ElementTree.parse(folder / "fields.pvd").getroot().iter("DataSet")
    return [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in entries]


def read_fields(path: Path) -> meshio.Mesh:
    """Mesh and fields of a field file.

    Raises:
        SceneError: it cannot be read.
    """
    try:
        return meshio.vtu.read(path)  # meshio.read would end the program
    except (OSError, ValueError, KeyError, SyntaxError, zlib.error, meshio.ReadError) as error:
        raise SceneError(f"{path}: cannot be read: {error}; expected a field file of a run") from error


@dataclass(frozen=True)
class Results:
    """A results folder, also that of a run which goes on or was killed.

    Attributes:
        folder: where it is.
        scene: the case.
        history: columns of ``history.csv`` by name, of length 0 before the first step.
        record: contents of ``run.json``; empty while the run has not ended.
        snapshots: times in s and names of the field files.
        errors: of columns of the history at each of its rows, by name, as a sequence of runs has told them.
    """

    folder: Path
    scene: Scene
    history: dict[str, Any]
    record: dict[str, Any]
    snapshots: list[tuple[float, str]]
    errors: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a folder.

        Raises:
            SceneError: it is no results folder, or its files cannot be read.
        """
        scene = folder / "scene.toml"
        if not scene.is_file():
            raise SceneError(f"{folder}: has no scene.toml; expected a results folder")
        try:
            table = tomllib.loads(scene.read_text(encoding="utf-8"))
            record = read_record(folder) if (folder / "run.json").exists() else {}
            snapshots = read_snapshots(folder) if (folder / "fields.pvd").exists() else []
            history, errors = (_columns(folder / name) for name in ("history.csv", ERROR_BANDS))
        except (OSError, ValueError, ElementTree.ParseError) as error:
            raise SceneError(f"{folder}: cannot be read: {error}; expected a results folder") from error
        if not np.array_equal(errors.pop("time", ()), history.get("time", ())):
            errors = {}  # the run has gone on since
        return cls(folder, Scene.from_table(table, source=str(scene)), history, record, snapshots, errors)

    @property
    def rows(self) -> int:
        """Number of accepted steps in the history."""
        return len(self.history.get("time", ()))

    def tool_columns(self, name: str) -> list[str]:
        """Columns of the history of that name, one for each tool, of those that it has."""
        columns = [numbered(name, number) for number in range(len(self.scene.tool))]
        return [column for column in columns if column in self.history]

    def interface_columns(self, name: str) -> list[str]:
        """Columns of the history of that name, one for each interface that has it."""
        return self._numbered_columns(name, self.scene.stack.layers - 1)

    def layer_columns(self, name: str) -> list[str]:
        """Columns of the history of that name, one for each layer that has it."""
        return self._numbered_columns(name, self.scene.stack.layers)

    def _numbered_columns(self, name: str, count: int) -> list[str]:
        columns = [f"{name}_{number}" for number in range(1, count + 1)]
        return [column for column in columns if column in self.history]


def _columns(path: Path) -> dict[str, Any]:
    """Columns of a table by name; none of one that is not there, or has no whole line."""
    rows = read_history(path) if path.exists() and "\n" in path.read_text(encoding="utf-8") else None
    return {} if rows is None or rows.dtype.names is None else {name: rows[name] for name in rows.dtype.names}


def varies_along_y(mesh: meshio.Mesh, share: float = VARIES) -> bool:
    """Whether the top face of a field file has other heights at another y, by more than a share of all its heights."""
    top = _top_nodes(mesh)
    lift = mesh.point_data["displacement"][top, 2]
    _, line = grid_lines(mesh.points[top, 0], float(np.ptp(mesh.points, axis=0).max()))
    low, high = np.full(line.max() + 1, np.inf), np.full(line.max() + 1, -np.inf)
    np.minimum.at(low, line, lift)
    np.maximum.at(high, line, lift)
    return bool((high - low).max() > share * np.ptp(lift) and np.ptp(lift) > 0)


def _top_nodes(mesh: meshio.Mesh) -> NDArray[np.int64]:
    height = mesh.points[:, 2]
    nodes: NDArray[np.int64] = np.flatnonzero(height >= height.max() - 1e-9 * np.ptp(mesh.points))
    return nodes
