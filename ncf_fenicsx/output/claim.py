"""A results folder belongs to one run at a time: a lock on a file in it, held from before anything is written.

The lock is one of the kernel (``flock``), not the mere presence of a file or a process number in it. It ends with the
process that holds it, however that dies, so a claim never outlives its run. It holds between containers that share a
folder, where process numbers and host names tell nothing, and on NFS. What the file says is for people to read.
"""

from __future__ import annotations

import errno
import fcntl
import os
import platform
import time
from contextlib import suppress
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Self

from mpi4py import MPI

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import CLAIM, check_folder

NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP}
"""Errors of file systems that know no locks."""


class Claim:
    """A results folder, claimed by a run: to be entered before anything is written, and left when all is.

    Rank 0 holds the lock. Leaving is not collective, so that a rank which fails alone does not wait for the others.

    Args:
        folder: made where it does not exist, and removed again if nothing is in it at the end.
        comm: ranks of the run.
        overwrite: whether the folder may hold results.
    """

    def __init__(self, folder: Path, comm: MPI.Comm, overwrite: bool) -> None:
        self.folder, self.comm, self.overwrite = folder, comm, overwrite
        self._path = folder / CLAIM
        self._file: FileIO | None = None
        self._made: list[Path] = []

    def __enter__(self) -> Self:
        """Claim the folder.

        Raises:
            SceneError: another run has claimed it, it holds results that may not be replaced, or cannot be written to.
        """
        try:
            on_root(self.comm, self._take)
        except BaseException:
            self._let_go()
            raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        del kind, error, trace
        if self._file is not None:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)
        self._let_go()

    def _take(self) -> None:
        check_folder(self.folder, overwrite=True)
        try:
            while self._file is None:
                self._file = self._locked()
            self._check_results(_words(self._file))
            since = time.strftime("%Y-%m-%d %H:%M:%S %z")
            self._file.truncate(0)
            self._file.seek(0)
            self._file.write(f"process {os.getpid()} on {platform.node()} since {since}\n".encode())
        except OSError as error:
            raise SceneError(f"{self.folder}: {error.strerror}; expected a folder that can be written to") from error

    def _check_results(self, left_by: str) -> None:
        """Whether the folder may be taken, once it is locked: a run that was there may just have ended."""
        try:
            check_folder(self.folder, self.overwrite, left_by)
        except SceneError:
            if not left_by:  # the file is new; that of a killed run stays, for the next one to tell
                self._path.unlink()
            raise

    def _locked(self) -> FileIO | None:
        """The open file with its lock; None where it was removed meanwhile, by the run that held it."""
        try:
            self._make_folder()
            new = not self._path.exists()
            file = FileIO(self._path, "x+" if new else "r+")
        except (FileExistsError, FileNotFoundError):
            return None
        try:
            self._lock(file, new)
            if _is_same(file, self._path):
                return file
        except BaseException:
            file.close()
            raise
        file.close()
        return None

    def _lock(self, file: FileIO, new: bool) -> None:
        """Lock the open file of a claim, at once or not at all."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            who = _words(file) or "it has just begun"
            words = f"another run writes there, {who}; wait for its end, or name another folder with --out"
            raise SceneError(f"{self.folder}: {words}") from None
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise
            if not new:  # here the file itself is the claim, and nothing tells whether its run still lives
                words = f"another run has claimed it, {_words(file)}, in a file system without locks"
                raise SceneError(f"{self.folder}: {words}; if that run is no more, remove {self._path}") from None

    def _make_folder(self) -> None:
        missing = [parent for parent in (self.folder, *self.folder.parents) if not parent.exists()]
        self.folder.mkdir(parents=True, exist_ok=True)
        self._made = self._made or missing

    def _let_go(self) -> None:
        """End the lock, and remove folders that were made for it and are empty."""
        if self._file is not None:
            self._file.close()
        with suppress(OSError):
            for folder in self._made:
                folder.rmdir()
        self._file, self._made = None, []


def _is_same(file: FileIO, path: Path) -> bool:
    """Whether a file that is locked is still the one that others would open."""
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    return False


def _words(file: FileIO) -> str:
    """What a claim says of who made it."""
    file.seek(0)
    return file.read(200).decode(errors="replace").strip()
