"""Where runs are done: on this machine, by a Dask scheduler that stands, or in jobs of a batch system."""

from __future__ import annotations

import logging
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dask_jobqueue
from distributed import Client, LocalCluster
from distributed.system import MEMORY_LIMIT

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.memory import expected_memory
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.output.safe_files import ResultError
from ncf_fenicsx.scene import Scene

BATCH_SYSTEMS = {
    "slurm": dask_jobqueue.SLURMCluster,
    "pbs": dask_jobqueue.PBSCluster,
    "lsf": dask_jobqueue.LSFCluster,
}
"""Options of ``--cluster``."""
SUBMIT = {"slurm": "sbatch", "pbs": "qsub", "lsf": "bsub"}
"""Programs that batch systems take jobs with."""
ANY_PORT = ":0"
TRIES = 1
"""How often a run is tried again whose worker has died."""
PATIENCE = 600.0
"""Seconds that a scheduler which has stopped answering is waited for."""


@dataclass(frozen=True)
class Place:
    """Where runs are done.

    Attributes:
        scheduler: address of one that stands, as ``tcp://host:8786``.
        batch_system: one of `BATCH_SYSTEMS`; queue, account and wall time are those of Dask's ``jobqueue.yaml``.
        workers: runs at a time; on this machine as many as cores and memory allow unless given.
        ranks: processes of each run.
        memory: of each run in GB.
    """

    scheduler: str | None = None
    batch_system: str | None = None
    workers: int | None = None
    ranks: int = 1
    memory: float = 1.0

    def __post_init__(self) -> None:
        if self.scheduler is not None and self.batch_system is not None:
            raise SceneError("--scheduler and --cluster: expected one of them")
        if self.batch_system is not None and self.batch_system not in BATCH_SYSTEMS:
            raise SceneError(f"--cluster {self.batch_system}: expected one of {', '.join(BATCH_SYSTEMS)}")
        if self.batch_system is not None and shutil.which(SUBMIT[self.batch_system]) is None:
            program = SUBMIT[self.batch_system]
            raise SceneError(f"--cluster {self.batch_system}: no {program} here; expected a machine that submits jobs")

    @property
    def at_a_time(self) -> int:
        """Runs that this machine can do at a time."""
        cores = len(os.sched_getaffinity(0)) // self.ranks
        return max(min(cores, int(MEMORY_LIMIT / 1e9 / self.memory)), 1)

    @contextmanager
    def opened(self) -> Iterator[Connection]:
        """Start what has to be started; it ends with the block.

        Raises:
            SceneError: the scheduler does not answer.
        """
        if self.scheduler is not None:
            with Connection(self.scheduler) as connection:
                yield connection
            return
        with self._cluster() as cluster, Connection(cluster) as connection:
            yield connection

    def _cluster(self) -> Any:
        if self.batch_system is not None:
            cluster = batch_cluster(self.batch_system, self.ranks, self.memory)
            cluster.scale(jobs=self.workers or 1)
            return cluster
        return LocalCluster(
            n_workers=self.workers or self.at_a_time,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,  # a run is a process of its own, which a worker's memory says nothing of
            dashboard_address=ANY_PORT,
            silence_logs=logging.CRITICAL,
            scheduler_kwargs={"allowed_failures": TRIES},
        )


def place_for(
    file: Path,
    overrides: tuple[str, ...],
    scheduler: str | None,
    cluster: str | None,
    workers: int | None,
    ranks: int,
) -> Place:
    """Where runs of a scene are done, with the memory that each needs.

    Raises:
        SceneError: the scene is not valid, or the options do not go together.
    """
    scene = Scene.read(file, overrides)
    return Place(scheduler, cluster, workers, ranks, expected_memory(scene, size_of(scene).unknowns))


def batch_cluster(name: str, ranks: int, memory: float) -> Any:
    """Jobs of a batch system, each with one worker that does one run at a time.

    Args:
        name: one of `BATCH_SYSTEMS`.
        ranks: cores that each job asks for.
        memory: in GB that each job asks for.
    """
    return BATCH_SYSTEMS[name](
        cores=ranks,
        processes=1,
        memory=f"{memory:.3g} GB",
        worker_extra_args=["--nthreads", "1", "--memory-limit", "0"],
        scheduler_options={"allowed_failures": TRIES, "dashboard": False, "dashboard_address": ANY_PORT},
    )


class Connection:
    """Connection to a scheduler, made anew when it breaks.

    Args:
        to: an address, or a cluster of Dask.
    """

    def __init__(self, to: Any) -> None:
        self._to = to
        self.client: Any = None

    def __enter__(self) -> Connection:
        try:
            self.client = self._connected()
        except (OSError, ValueError) as error:
            expected = "expected the address of a Dask scheduler, such as tcp://host:8786"
            raise SceneError(f"--scheduler {self._to}: does not answer; {expected}") from error
        return self

    def __exit__(self, *error: object) -> None:
        self._close()

    @property
    def broken(self) -> bool:
        """Whether the scheduler has stopped answering."""
        return bool(self.client.status != "running")

    @property
    def at_a_time(self) -> int:
        """Runs that its workers do at a time, at least one."""
        return max(sum(self.client.nthreads().values()), 1)

    def renew(self) -> None:
        """Connect again, as soon as the scheduler is there again.

        Raises:
            ResultError: it is not within `PATIENCE`.
        """
        self._close()
        end = time.monotonic() + PATIENCE
        while True:
            try:
                self.client = self._connected()
                return
            except OSError as error:
                if time.monotonic() > end:
                    words = f"{self._to}: the scheduler has not answered for {PATIENCE:g} s; the rows so far are kept"
                    raise ResultError(f"{words}; the same command goes on") from error
                time.sleep(0.2)

    def _connected(self) -> Any:
        return Client(self._to, timeout=5)

    def _close(self) -> None:
        with suppress(OSError):
            self.client.close(timeout=1)
