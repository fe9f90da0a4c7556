"""What a run costs, measured in its own unit: one assembly and one cold factorisation of its tangent."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.report.reading import read_record
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation import Simulation
from ncf_fenicsx.study.machine import machine

REPEATS = 3
BARE = {"picture": False, "report": False, "fields_every": 1_000_000, "checkpoint_interval": 1e9}


def benchmark_run(scene: Scene, comm: MPI.Comm = MPI.COMM_WORLD) -> str:
    """Run a scene on all ranks, without pictures and checkpoints, and weigh its time; a Markdown table.

    Args:
        scene: the case.
        comm: ranks that share the work.

    Raises:
        SceneError: the scene cannot be run.
    """
    bare = scene.model_copy(update={"output": scene.output.model_copy(update=BARE)})
    folder = Path(on_root(comm, tempfile.mkdtemp))
    try:
        simulation = Simulation(bare, folder, comm, overwrite=True)
        start = time.perf_counter()
        result = simulation.run()
        seconds = time.perf_counter() - start
        assembly, factorisation = _unit(simulation)  # at the end: the run's peak of memory is its own
        pieces = _pieces(simulation)
        record = on_root(comm, lambda: read_record(folder))
    finally:
        on_root(comm, lambda: shutil.rmtree(folder))
    unit = assembly + factorisation
    last = result.history[-1] if result.history else {}
    rows = {
        "unknowns, ranks": f"{record['unknowns']:,}, {record['ranks']}",
        "ending": f"{record['ending']} at {record['time']:.4g} s: {record['reason']}",
        "assembly of the tangent, cold factorisation": f"{assembly:.2f} s, {factorisation:.2f} s",
        "run, over both": f"{seconds:.1f} s, {seconds / unit:.1f}",
        "Newton iterations, steps, cuts": f"{record['newton_iterations']}, {record['steps']}, {record['step_cuts']}",
        "factorisations, Krylov steps": f"{record['factorisations']}, {record['krylov_steps']}",
        "peak memory": f"{record['peak_memory_mb'] / 1024:.2f} GB",
        "force at the end": f"{last.get('tool_force', 0.0):.4g} N",
    }
    rows |= {f"of it {phase}": f"{100 * value / seconds:.1f} %" for phase, value in record["seconds"].items() if value}
    rows |= {f"one {piece}": f"{1e3 * value:.3g} ms" for piece, value in pieces.items()}
    lines = [f"{scene.title}; {machine()}", "", "| what | measured |", "|---|---|"]
    return "\n".join([*lines, *(f"| {what} | {value} |" for what, value in rows.items())])


def _unit(simulation: Simulation) -> tuple[float, float]:
    """Seconds of one assembly and of one factorisation of the whole that knows nothing before."""
    newton, comm = simulation.newton, simulation.comm
    return _seconds(newton.tangent.assemble, comm), _seconds(newton.factorise, comm)


def _pieces(simulation: Simulation) -> dict[str, float]:
    """Least seconds of what the run's iterations and steps consist of."""
    pieces = simulation.newton.pieces | {"pairing of layers": simulation.problem.contacts.pair}
    return {name: min(_seconds(work, simulation.comm) for _ in range(REPEATS)) for name, work in pieces.items()}


def _seconds(work: Callable[[], object], comm: MPI.Comm) -> float:
    """Wall time on all ranks."""
    comm.barrier()
    start = time.perf_counter()
    work()
    comm.barrier()
    return time.perf_counter() - start
