"""What a scene will build, before it is run."""

from __future__ import annotations

from mpi4py import MPI

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.hexahedra import lower_tag
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.stepping import StepControl

MEMORY_OF_PROGRAM = 0.18
MEMORY_PER_UNKNOWN = {True: 7.4e-6, False: 9.6e-6}
"""GB, symmetric or not, measured with ``ncf-fenicsx run`` (peak_memory_mb of run.json): see the README, "Memory"."""


def preview(scene: Scene, control: StepControl, duration: float) -> str:
    """Lines on what will be built: mesh, terms, unknowns, steps, memory.

    Args:
        scene: the case.
        control: its step sizes.
        duration: of its path in s.

    Raises:
        SceneError: its mesh is not valid, or a tool starts in the stack.
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
        f"residual: {'; '.join(terms)}",
        f"initial fibre volume fraction: {scene.stack.initial_volume_fraction:.6f}",
        f"unknowns: {unknowns}",
        f"states at quadrature points: {', '.join(laws.initial_states(0.0)) or 'none'}",
        "tangent: " + ("symmetric, LDL^T" if scene.symmetric else "not symmetric, LU"),
        f"expected memory: {MEMORY_OF_PROGRAM + MEMORY_PER_UNKNOWN[scene.symmetric] * unknowns:.2g} GB",
        f"path: {duration:.4g} s in steps of {control.first:.3g} s (first) to {control.largest:.3g} s (largest)",
        *(f"caution: {caution}" for caution in (*scene.cautions, *stack.cautions)),
    ]
    return "\n".join(lines)
