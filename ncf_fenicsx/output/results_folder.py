"""Files of a run: history, fields, the resolved scene and the record of the run. Rank 0 writes, once."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.parallel import gather_rows, on_root
from ncf_fenicsx.mesh.stack_file import VTK_TO_TENSOR
from ncf_fenicsx.output.checkpoint import NAME
from ncf_fenicsx.output.history_file import HistoryFile, Row
from ncf_fenicsx.output.measures import Measures
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.scene.scene_file import WRITTEN

ACCURACY = "accuracy.json"
"""What a sequence of runs of finer and finer levels has come to."""
ERROR_BANDS = "error_bands.csv"
"""Of the finest run of a sequence, or of one with a companion: errors of its history at each of its rows."""
FILES = (
    WRITTEN,
    "scene.toml",
    "history.csv",
    "fields.pvd",
    "run.json",
    "summary.png",
    "report.html",
    "critical_mode.vtu",
    ACCURACY,
    ERROR_BANDS,
    NAME,
)
COMPANION = "companion"
"""Folder with the results of half the mesh and half the steps."""
FOLDERS = ("export", COMPANION)
CLAIM = ".claim"
"""File that the run which writes to a folder holds there; none of its results."""


def check_folder(folder: Path, overwrite: bool, left_by: str = "") -> None:
    """Whether a folder can take results; nothing is written yet.

    Args:
        folder: for the results.
        overwrite: whether results in it may be replaced.
        left_by: whose claim is left in it, of a run that was killed.

    Raises:
        SceneError: it holds results already and may not be overwritten, or cannot be written to.
    """
    if folder.exists() and not folder.is_dir():
        raise SceneError(f"{folder}: is a file; expected a folder for the results")
    if not overwrite and folder.exists() and any(file.name != CLAIM for file in folder.iterdir()):
        whose = f"results of a run that was killed, {left_by}; go on with --restart," if left_by else "results already;"
        raise SceneError(f"{folder}: holds {whose} name another folder with --out, or allow --overwrite")
    above = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise SceneError(f"{folder}: cannot be written to; expected a folder that can")


def prepare_folder(folder: Path) -> None:
    """Make the folder for results, without those of an older run.

    Raises:
        SceneError: it cannot be written to.
    """
    try:
        (folder / "fields").mkdir(parents=True, exist_ok=True)
        for old in [*(folder / "fields").glob("*.vtu"), *(folder / name for name in FILES)]:
            old.unlink(missing_ok=True)
        for name in FOLDERS:
            if (folder / name).exists():
                shutil.rmtree(folder / name)
    except OSError as error:
        raise SceneError(f"{folder}: {error.strerror}; expected a folder that can be written to") from error


class Results:
    """The results folder of a run; every call is collective.

    Args:
        folder: where to write.
        problem: whose fields are written.
        measures: cell means of the problem.
    """

    def __init__(self, folder: Path, problem: Problem, measures: Measures) -> None:
        self.folder, self.problem, self.measures, self.comm = folder, problem, measures, problem.comm
        self.snapshots: list[tuple[float, str]] = []
        self._history = HistoryFile(folder / "history.csv")
        space = problem.space
        to_global = space.dofmap.index_map.local_to_global
        cells = space.dofmap.list[: len(problem.stack.layer)]
        self._owned = space.dofmap.index_map.size_local
        self._points = gather_rows(self.comm, space.tabulate_dof_coordinates()[: self._owned])
        self._pieces = problem.stack.element.hexahedra
        self._cells = gather_rows(self.comm, to_global(cells[:, self._pieces].ravel()).reshape(-1, 8))
        self._layer = gather_rows(self.comm, self._of_pieces(problem.stack.layer))

    def _of_pieces(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the pieces that cells are drawn by, from those of the cells."""
        return np.repeat(values, len(self._pieces))

    def text(self, name: str, content: str) -> None:
        """Write a text file."""
        on_root(self.comm, lambda: _write_text(self.folder / name, content))

    def record(self, record: dict[str, Any]) -> None:
        """Write ``run.json``."""
        self.text("run.json", json.dumps(record, indent=2) + "\n")

    def append(self, row: Row) -> None:
        """Add a row to ``history.csv``; it is on the disk when this returns."""
        on_root(self.comm, lambda: self._history.append(row))

    def resume(self, rows: int, snapshots: list[tuple[float, str]]) -> list[Row]:
        """Go on after a number of rows and some field files, without what was written after them; those rows."""
        self.snapshots = [(time, name) for time, name in snapshots]
        return on_root(self.comm, lambda: self._cut(rows))

    def _cut(self, rows: int) -> list[Row]:
        kept = {self.folder / name for _, name in self.snapshots}
        for file in {*(self.folder / "fields").glob("*.vtu")} - kept:
            file.unlink()
        (self.folder / "run.json").unlink(missing_ok=True)  # it tells how the run ended that now goes on
        return self._history.cut(rows)

    def fields(self, time: float) -> None:
        """Write the committed fields for ParaView: one file, and the collection that lists all of them."""
        displacement = self.problem.displacement.x.array.reshape(-1, 3)[: self._owned]
        nodes = {"displacement": displacement}
        nodes |= {name: values[: self._owned] for name, values in self.measures.contacts.nodes.items()}
        point_data = {name: gather_rows(self.comm, values) for name, values in nodes.items()}
        cell_data = {
            name: gather_rows(self.comm, self._of_pieces(values)) for name, values in self.measures.cells.items()
        }
        on_root(self.comm, lambda: self._write_fields(time, point_data, cell_data))

    def mode(self, mode: NDArray[np.float64]) -> None:
        """Write ``critical_mode.vtu``, a mode at this rank's local nodes of shape (nodes, 3)."""
        gathered = gather_rows(self.comm, mode[: self._owned])
        on_root(self.comm, lambda: self._write_mesh("critical_mode.vtu", {"critical_mode": gathered}, {}))

    def _write_fields(
        self,
        time: float,
        nodes: dict[str, NDArray[np.float64] | None],
        cells: dict[str, NDArray[np.float64] | None],
    ) -> None:
        name = f"fields/{len(self.snapshots):04d}.vtu"
        self._write_mesh(name, nodes, cells)
        self.snapshots.append((time, name))
        entries = "".join(f'<DataSet timestep="{time!r}" part="0" file="{name}"/>\n' for time, name in self.snapshots)
        head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        _write_text(self.folder / "fields.pvd", f"{head}{entries}</Collection>\n</VTKFile>\n")

    def _write_mesh(
        self, name: str, nodes: dict[str, NDArray[np.float64] | None], cells: dict[str, NDArray[np.float64] | None]
    ) -> None:
        assert self._cells is not None
        assert self._layer is not None
        vtk = self._cells[:, VTK_TO_TENSOR]  # its own inverse
        data = {key: [value] for key, value in cells.items()} | {"layer": [self._layer + 1]}
        mesh = meshio.Mesh(self._points, [("hexahedron", vtk)], nodes, data)
        replace(self.folder / name, mesh.write)


def _write_text(path: Path, content: str) -> None:
    replace(path, lambda beside: beside.write_text(content, encoding="utf-8"))
