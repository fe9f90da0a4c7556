"""The committed state of a run in one HDF5 file, from which any number of ranks can go on."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.parallel import gather_rows, on_root
from ncf_fenicsx.mesh.state_parts import Place, StatePart
from ncf_fenicsx.output.safe_files import replace

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NAME = "checkpoint.h5"


class Checkpoint:
    """A checkpoint's file; every call is collective.

    Values stand in the order of the mesh's nodes and cells before it was shared out among ranks.

    Args:
        folder: of the run's results.
        problem: whose state it is.
        more: parts that are not the problem's.
    """

    def __init__(self, folder: Path, problem: Problem, more: dict[str, StatePart]) -> None:
        self._more = more
        self.path, self.problem, self.comm = folder / NAME, problem, problem.comm
        self._numbers = {
            Place.NODES: problem.stack.node_numbers(problem.space),
            Place.CELLS: problem.stack.cell_numbers,
        }
        self._owned = {Place.NODES: problem.space.dofmap.index_map.size_local, Place.CELLS: len(problem.stack.layer)}

    def save(self, progress: dict[str, Any]) -> None:
        """Replace the file by the present committed state; the old one stays until the new one is on the disk.

        Args:
            progress: how far the run is, in numbers and texts.

        Raises:
            ResultError: it cannot be written.
        """
        parts = {name: self._gathered(part.place, part.read()) for name, part in self._parts().items()}
        on_root(self.comm, lambda: replace(self.path, lambda path: _write(path, parts, progress)))

    def _parts(self) -> dict[str, StatePart]:
        return self.problem.parts() | self._more

    def _gathered(self, place: Place, values: Floats) -> Floats | None:
        if place is Place.EVERYWHERE:
            return values
        count = len(self._numbers[place])
        width = self.comm.allreduce(values.size // count if count else 0, MPI.MAX)  # a rank may have no cells at all
        rows = values.reshape(count, width)[: self._owned[place]]
        numbers = gather_rows(self.comm, self._numbers[place][: self._owned[place]])
        gathered = gather_rows(self.comm, rows)
        return None if gathered is None or numbers is None else gathered[np.argsort(numbers)]

    def load(self) -> dict[str, Any]:
        """Give the problem the saved state.

        Returns:
            How far the run was.

        Raises:
            SceneError: the file cannot be read, or is of another scene.
        """
        saved, progress = on_root(self.comm, lambda: _read(self.path))
        parts = self._parts()
        if set(saved) != set(parts):
            raise SceneError(
                f"{self.path}: its parts are not those of the scene; expected the checkpoint of that scene"
            )
        for name, part in parts.items():
            numbers = self._numbers.get(part.place)
            total = (
                len(saved[name]) if numbers is None else self.comm.allreduce(int(numbers.max(initial=-1)), MPI.MAX) + 1
            )
            if len(saved[name]) != total:
                raise SceneError(
                    f"{self.path}: {len(saved[name])} rows of {name}; expected {total} on the scene's mesh"
                )
            part.write(saved[name] if numbers is None else saved[name][numbers])
        self.problem.resume(progress["time"])
        return dict(progress)


def _write(path: Path, parts: dict[str, Floats | None], progress: dict[str, Any]) -> None:
    memory = BytesIO()  # HDF5 itself does not survive a disk that is full
    with h5py.File(memory, "w") as file:
        file.attrs["progress"] = json.dumps(progress)
        for name, values in parts.items():
            file[name] = values
    path.write_bytes(memory.getvalue())


def _read(path: Path) -> tuple[dict[str, Floats], dict[str, Any]]:
    try:
        with h5py.File(path, "r") as file:
            return {name: file[name][()] for name in file}, json.loads(file.attrs["progress"])
    except (OSError, KeyError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read; expected the checkpoint of a run") from error
