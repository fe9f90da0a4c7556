"""Files that are whole at any moment: a new one takes the place of the old only when it is on the disk."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


class ResultError(RuntimeError):
    """Results cannot be written; its message names the file and why. What was written before stays as it was."""


def replace(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file beside its final place and move it there when all of it is on the disk.

    Args:
        path: its final place.
        write: writes to the path that it is given.

    Raises:
        ResultError: it cannot be written; the old file, if any, is untouched.
    """
    beside = path.with_name(f"{path.stem}.new{path.suffix}")
    with told(path):
        try:
            write(beside)
            with beside.open("rb+") as file:
                os.fsync(file.fileno())
            beside.replace(path)
        except OSError:
            beside.unlink(missing_ok=True)
            raise


@contextmanager
def told(path: Path) -> Iterator[None]:
    """Turn an error of the system into a `ResultError` that names a path."""
    try:
        yield
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror or error}; what was written before stays readable") from error
