"""What a run of a scene would build and cost, from its numbers alone."""

from __future__ import annotations

import numpy as np

from ncf_fenicsx.mesh.memory import expected_memory
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.mesh.tool_placement import AXES
from ncf_fenicsx.parameters.kinds import numbered
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.simulation.stepping import pieces


def preview(scene: Scene) -> str:
    """Lines on what will be built: mesh, terms, unknowns, steps, memory. Only a mesh file is read, nothing is built.

    Args:
        scene: the case; its divisions are known.

    Raises:
        SceneError: its mesh is not valid, or a tool starts in the stack or never meets it.
    """
    size = size_of(scene)
    unknowns, facing = size.unknowns, size.facing
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
        *_lengths(scene),
        f"mesh: {size.cells} hexahedra, {size.nodes} nodes, {scene.stack.layers} layers",
        *_positions_by_mesh(scene, size.position),
        f"residual: {'; '.join(terms)}",
        f"initial fibre volume fraction: {scene.stack.initial_volume_fraction:.6f}",
        f"unknowns: {unknowns}",
        f"states at quadrature points: {', '.join(laws.initial_states(0.0)) or 'none'}",
        "tangent: " + ("symmetric, LDL^T" if scene.symmetric else "not symmetric, LU"),
        f"expected memory: {expected_memory(scene, unknowns):.2g} GB",
        *(
            f"path to {end:.4g} s in steps of {control.first:.3g} s (first) to {control.largest:.3g} s (largest)"
            for end, control in pieces(scene)
        ),
        *(f"caution: {caution}" for caution in (*scene.cautions, *size.cautions)),
    ]
    return "\n".join(lines)


def _lengths(scene: Scene) -> list[str]:
    """How long the elements are that nodes are given for."""
    words = []
    for axis, positions in zip(AXES, scene.stack.nodes or (), strict=False):
        lengths = 1e3 * np.diff(positions)
        shortest, longest = f"{lengths.min():.3g}", f"{lengths.max():.3g}"
        span = shortest if shortest == longest else f"{shortest} to {longest}"
        words.append(f"{len(lengths)} along {axis}, {span} mm long")
    return [f"elements of each layer: {'; '.join(words)}"] if words else []


def _positions_by_mesh(scene: Scene, position: tuple[float, float]) -> list[str]:
    """Where tools and mould are that a mesh file has given a position."""
    if scene.stack.mesh is None:
        return []
    names = [numbered("tool", number) for number in range(len(scene.tool))] + ["mould"]
    shown = ", ".join(f"{round(1e3 * length, 9) + 0.0:.4g}" for length in position)
    surfaces = zip(names, scene.rigid_surfaces, strict=False)
    by_mesh = [name for name, surface in surfaces if "position" not in surface.model_fields_set]
    return [f"{name}.position: ({shown}) mm, by the mesh" for name in by_mesh]
