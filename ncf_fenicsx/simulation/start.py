"""How every run begins: the mesh of its scene, what a user has to know of both, the problem."""

from __future__ import annotations

from pathlib import Path

from mpi4py import MPI

from ncf_fenicsx.kinds import numbered
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import StackMesh, build_mesh
from ncf_fenicsx.mesh.hexahedra import lower_tag
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import check_folder
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.progress_bar import ProgressBar
from ncf_fenicsx.simulation.stepping import pieces
from ncf_fenicsx.solver.timing import Phases

MEMORY_OF_PROGRAM = 0.18
MEMORY_PER_UNKNOWN = {True: 7.4e-6, False: 9.6e-6}
"""GB, symmetric or not, measured with ``ncf-fenicsx run`` (peak_memory_mb of run.json): see docs/performance.md."""


def build_problem(
    scene: Scene, folder: Path, overwrite: bool, comm: MPI.Comm, progress: ProgressBar, phases: Phases
) -> Problem:
    """The problem of a scene whose results go to a folder.

    Args:
        scene: the case.
        folder: for results; nothing is written yet.
        overwrite: whether results in it may be replaced.
        comm: ranks that share the work.
        progress: tells cautions, and what takes time.
        phases: clock that mesh and forms are booked on.

    Raises:
        SceneError: the scene's mesh is not valid, a tool starts in the stack or never meets it, or the folder cannot be
            used.
    """
    with phases("mesh"):
        stack = build_mesh(scene, comm)
    on_root(comm, lambda: check_folder(folder, overwrite))
    for caution in (*scene.cautions, *stack.cautions):
        progress.caution(caution)
    progress.note("compiling forms: seconds the first time, none after")
    with phases("forms"):
        problem = Problem(scene, stack)
        problem.contacts.check_start()
    return problem


def preview(scene: Scene) -> str:
    """Lines on what will be built: mesh, terms, unknowns, steps, memory.

    Args:
        scene: the case.

    Raises:
        SceneError: its mesh is not valid, or a tool starts in the stack or never meets it.
    """
    stack = build_mesh(scene, MPI.COMM_SELF)
    if scene.rigid_surfaces:
        Problem(scene, stack).contacts.check_start()
    nodes = int(stack.numbers.max()) + 1
    unknowns = 3 * nodes
    facing = sum(len(stack.facets(lower_tag(layer))) for layer in stack.open_interfaces)
    laws = scene.laws
    terms = [f"{law.family} ({law.kind})" for law in laws.chosen]
    if scene.gravity:
        terms.append("weight")
    terms += [f"contact with a {tool.kind} ({tool.contact.kind})" for tool in scene.tool]
    if scene.mould is not None:
        terms.append(f"contact with a mould, {scene.mould.kind} ({scene.mould.contact.kind})")
    if facing:
        terms.append(f"contact of layers on {facing} facing facets")
    lines = [
        f"mesh: {len(stack.layer)} hexahedra, {nodes} nodes, {scene.stack.layers} layers",
        *_places(scene, stack),
        f"residual: {'; '.join(terms)}",
        f"initial fibre volume fraction: {scene.stack.initial_volume_fraction:.6f}",
        f"unknowns: {unknowns}",
        f"states at quadrature points: {', '.join(laws.initial_states(0.0)) or 'none'}",
        "tangent: " + ("symmetric, LDL^T" if scene.symmetric else "not symmetric, LU"),
        f"expected memory: {MEMORY_OF_PROGRAM + MEMORY_PER_UNKNOWN[scene.symmetric] * unknowns:.2g} GB",
        *(
            f"path to {end:.4g} s in steps of {control.first:.3g} s (first) to {control.largest:.3g} s (largest)"
            for end, control in pieces(scene)
        ),
        *(f"caution: {caution}" for caution in (*scene.cautions, *stack.cautions)),
    ]
    return "\n".join(lines)


def _places(scene: Scene, stack: StackMesh) -> list[str]:
    """Where tools and mould are that a mesh file has given a place."""
    if scene.stack.mesh is None:
        return []
    names = [numbered("tool", number) for number in range(len(scene.tool))] + ["mould"]
    place = ", ".join(f"{round(1e3 * length, 9) + 0.0:.4g}" for length in stack.place)
    surfaces = zip(names, scene.rigid_surfaces, strict=False)
    by_mesh = [name for name, surface in surfaces if "position" not in surface.model_fields_set]
    return [f"{name}.position: ({place}) mm, by the mesh" for name in by_mesh]
