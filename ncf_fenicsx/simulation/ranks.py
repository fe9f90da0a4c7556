"""How many ranks pay for a scene on this machine, and a run started on them."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.compat import processor_lines
from ncf_fenicsx.simulation.progress_bar import LAUNCHERS

UNKNOWNS_OF_A_RANK = 9000
"""Unknowns that a rank should have at least: see docs/performance.md."""
ALONE = 18_000
"""Unknowns below which one rank is as fast as two, measured with the demos."""
LOOK = 0.25
"""Time in s for which the processors are watched, to see how many are idle."""
MEMORY_OF_A_RANK = 0.2e9
"""Memory in byte that each rank takes for the program alone."""
AS_ASKED = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "PRTE_MCA_hwloc_default_binding_policy": "none",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
"""For Open MPI, 5 and 4: as whoever calls it, and not bound to the cores that another run was bound to."""
PASSED_ON: dict[int, signal.Signals] = {signal.SIGINT: signal.SIGUSR1, signal.SIGTERM: signal.SIGUSR2}
"""What a launcher passes on to its ranks in place of what would make it kill them."""
FEWEST_ALLOWED = 2
"""Ranks that may be asked for on any machine, to see what two of them do."""
PARENT_DIED = 1
"""Linux's PR_SET_PDEATHSIG."""


def ranks_that_pay(unknowns: int, memory: float) -> int:
    """Number of ranks for a run with so many unknowns and so much memory (byte), on the cores that are free to use."""
    if unknowns < ALONE or is_launched() or shutil.which("mpirun") is None:
        return 1
    most_by_memory = int(1 + max(free_memory() - memory, 0.0) / MEMORY_OF_A_RANK)
    cores = physical_cores()
    idle = idle_cores() if cores > 1 else cores
    return max(min(unknowns // UNKNOWNS_OF_A_RANK, cores, idle, most_by_memory), 1)


def is_launched() -> bool:
    """Whether a launcher has started this process as a rank."""
    return bool(LAUNCHERS & set(os.environ))


def physical_cores() -> int:
    """Cores that this process may use, without the second threads of each, and within the quota of a container."""
    allowed, cores, number, package = os.sched_getaffinity(0), set(), -1, "0"
    for line in processor_lines():
        name, _, value = (part.strip() for part in line.partition(":"))
        if name == "processor":
            number = int(value)
        elif name == "physical id":
            package = value
        elif name == "core id" and number in allowed:
            cores.add((package, value))
    return max(min(len(cores) or len(allowed), _quota()), 1)


def idle_cores() -> int:
    """Processors that do nothing at present: ranks that share one with other work wait for each other all the time."""
    before = _processor_times()
    time.sleep(LOOK)
    idle = 0.0
    for old, new in zip(before, _processor_times(), strict=True):
        spent = [after - start for start, after in zip(old, new, strict=True)]
        idle += (spent[3] + spent[4]) / max(sum(spent), 1)  # idle, and waiting for files
    return round(idle) if before else sys.maxsize


def _processor_times() -> list[list[int]]:
    """Ticks that each processor has spent on users, ..., idle, waiting, ...; none where the system does not tell."""
    lines = (line.split() for line in _text("/proc/stat").splitlines())
    return [[int(word) for word in words[1:9]] for words in lines if words[0].startswith("cpu") and words[0] != "cpu"]


def _quota() -> int:
    """Cores that a control group allows, rounded down; no limit where it says none."""
    words = _text("/sys/fs/cgroup/cpu.max").split()
    return int(words[0]) // int(words[1]) if len(words) == 2 and words[0] != "max" else sys.maxsize


def free_memory() -> float:
    """Memory in byte that a new process may take, without swapping and within the limit of a container."""
    lines = [line.split() for line in _text("/proc/meminfo").splitlines()]
    free = next((1024 * float(words[1]) for words in lines if words[0] == "MemAvailable:"), float("inf"))
    limit, used = (_text(f"/sys/fs/cgroup/memory.{name}").strip() for name in ("max", "current"))
    return min(free, float(limit) - float(used)) if limit.isdigit() and used.isdigit() else free


def _text(path: str) -> str:
    """A file of the system; nothing where it has none."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError:
        return ""


def run_on(ranks: int, arguments: Sequence[str]) -> int:
    """Call this program anew on some ranks, and wait for its end; its exit code.

    Ctrl-C and SIGTERM reach the ranks as signals that the launcher passes on, so that they save their state; a second
    one ends them at once. If this process is killed, the ranks end too.

    Raises:
        SceneError: there is no launcher, or there are more ranks than cores to run them.
    """
    most = max(physical_cores(), FEWEST_ALLOWED)
    if ranks > most:
        raise SceneError(f"--ranks {ranks}: expected at most {most} on this machine; mpirun starts more")
    if shutil.which("mpirun") is None:
        raise SceneError(f"--ranks {ranks}: mpirun is not installed; expected --ranks 1")
    words = ["mpirun", "-n", str(ranks), sys.executable, "-m", "ncf_fenicsx", *arguments]
    launched = subprocess.Popen(
        words, env=os.environ | AS_ASKED, start_new_session=True, preexec_fn=_end_with_parent, stdin=subprocess.DEVNULL
    )
    heard: list[int] = []

    def pass_on(number: int, frame: FrameType | None) -> None:
        del frame
        launched.send_signal(number if heard else PASSED_ON[number])
        heard.append(number)

    for number in PASSED_ON:
        signal.signal(number, pass_on)
    return launched.wait()


def _end_with_parent() -> None:
    ctypes.CDLL(None).prctl(PARENT_DIED, signal.SIGTERM)
