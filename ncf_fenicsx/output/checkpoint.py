"""The committed state of a run in one HDF5 file, from which any number of ranks can go on."""

from __future__ import annotations

import json
from collections.abc import Sequence
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
from ncf_fenicsx.mesh.state_fields import Location, StateField
from ncf_fenicsx.output.safe_files import replace

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NAME = "checkpoint.h5"


class Checkpoint:
    """A checkpoint's file; every call is collective.

    Values stand in the order of the mesh's nodes and cells before it was shared out among ranks.

    Args:
        folder: of the run's results.
        problem: whose mesh it is on.
        state: all fields of state.
    """

    def __init__(self, folder: Path, problem: Problem, state: Sequence[StateField]) -> None:
        self.state = state
        self.path, self.comm = folder / NAME, problem.comm
        self._numbers = {
            Location.NODES: problem.stack.node_numbers(problem.space),
            Location.CELLS: problem.stack.cell_numbers,
        }
        nodes, cells = problem.space.dofmap.index_map.size_local, len(problem.stack.layer)
        self._owned = {Location.NODES: nodes, Location.CELLS: cells}

    def save(self, progress: dict[str, Any]) -> None:
        """Replace the file by the present committed state; the old one stays until the new one is on the disk.

        Args:
            progress: how far the run is, in numbers and texts.

        Raises:
            ResultError: it cannot be written.
        """
        rows = {field.name: self._gathered(field.location, field.committed_rows()) for field in self.state}
        on_root(self.comm, lambda: replace(self.path, lambda path: _write(path, rows, progress)))

    def _gathered(self, location: Location, values: Floats) -> Floats | None:
        if location is Location.EVERYWHERE:
            return values
        count = len(self._numbers[location])
        width = self.comm.allreduce(values.size // count if count else 0, MPI.MAX)  # a rank may have no cells at all
        rows = values.reshape(count, width)[: self._owned[location]]
        numbers = gather_rows(self.comm, self._numbers[location][: self._owned[location]])
        gathered = gather_rows(self.comm, rows)
        return None if gathered is None or numbers is None else gathered[np.argsort(numbers)]

    def load(self) -> dict[str, Any]:
        """Give all fields their saved values, as committed ones.

        Returns:
            How far the run was.

        Raises:
            SceneError: the file cannot be read, or is of another scene.
        """
        saved, progress = on_root(self.comm, lambda: _read(self.path))
        if set(saved) != {field.name for field in self.state}:
            raise SceneError(
                f"{self.path}: its fields are not those of the scene; expected the checkpoint of that scene"
            )
        for field in self.state:
            rows = saved[field.name]
            numbers = self._numbers.get(field.location)
            total = field.values.size if numbers is None else self._total(numbers)
            if len(rows) != total:
                raise SceneError(f"{self.path}: {len(rows)} rows of {field.name}; expected {total} on the scene's mesh")
            field.commit(rows if numbers is None else rows[numbers])
        return dict(progress)

    def _total(self, numbers: Integers) -> int:
        """Rows of all ranks."""
        return int(self.comm.allreduce(int(numbers.max(initial=-1)), MPI.MAX)) + 1


def _write(path: Path, fields: dict[str, Floats | None], progress: dict[str, Any]) -> None:
    memory = BytesIO()  # HDF5 itself does not survive a disk that is full
    with h5py.File(memory, "w") as file:
        file.attrs["progress"] = json.dumps(progress)
        for name, values in fields.items():
            file[name] = values
    path.write_bytes(memory.getvalue())


def read_progress(path: Path) -> dict[str, Any]:
    """How far the run of a checkpoint was.

    Raises:
        SceneError: the file cannot be read.
    """
    return _read(path)[1]


def _read(path: Path) -> tuple[dict[str, Floats], dict[str, Any]]:
    try:
        with h5py.File(path, "r") as file:
            return {name: file[name][()] for name in file}, json.loads(file.attrs["progress"])
    except (OSError, KeyError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read; expected the checkpoint of a run") from error
