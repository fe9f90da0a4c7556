"""A case in one sentence: what is pressed by what, how far, how fast."""

from __future__ import annotations

from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.tools.path import Segment
from ncf_fenicsx.tools.rigid_surface import Tool

SIZES = {"radius": "radius", "width": "width", "size": "size"}
"""Keys of tools that a sentence tells."""

AXES = ("x", "y", "z")


def short(value: float) -> str:
    """Four digits of a number."""
    return f"{value:.4g}"


def sentence(results: Results) -> str:
    """What is pressed by what, how far, how fast."""
    scene, stack = results.scene, results.scene.stack
    layers = "One layer" if stack.layers == 1 else f"{stack.layers} layers"
    material = "" if scene.laws.solid is None else " of a solid"
    what = f"{layers}{material} of {_mm(stack.thickness)}"
    if stack.mesh is None:
        what += f", {_mm(*stack.size)} modelled"
    if stack.sides.copies > 1:
        what += f" (1/{stack.sides.copies} by symmetry)"
    on = "" if scene.mould is None else f" on a {scene.mould.kind} mould"
    if not scene.tool:
        return f"{what}, at rest{on} for {short(float(scene.duration or 0))} s."
    if len(scene.tool) == 1:
        return f"{what}, pressed{on} by {_tool(scene.tool[0])}, which {_path(scene.tool[0].path)}."
    tools = "; ".join(f"{_tool(tool)}, which {_path(tool.path)}" for tool in scene.tool)
    return f"{what}, pressed{on} by {len(scene.tool)} tools: {tools}."


def _mm(*lengths: float) -> str:
    return " x ".join(short(1e3 * length) for length in lengths) + " mm"


def _tool(tool: Tool) -> str:
    sizes = []
    for key, word in SIZES.items():
        if hasattr(tool, key):
            value = getattr(tool, key)
            many = value if isinstance(value, tuple) else (value,)
            sizes.append(f"endless {word}" if value is None else f"{word} {_mm(*many)}")
    return f"a {tool.kind.replace('_', ' ')}" + (f" ({', '.join(sizes)})" if sizes else "")


def _path(path: tuple[Segment, ...]) -> str:
    """A path in words, piece by piece."""
    pieces = [_piece(segment) for segment in path]
    return ", then ".join(pieces[:4]) + (f", and {len(pieces) - 4} more pieces" if len(pieces) > 4 else "")


def _piece(segment: Segment) -> str:
    force = "" if segment.force is None else f" under {short(segment.force)} N"
    if segment.travel is None or segment.speed is None:
        return f"rests for {short(segment.duration)} s{force}"
    speed = f"at {short(6e4 * segment.speed)} mm/min"
    x, y, z = segment.travel
    words = [f"{_mm(abs(z))} {'down' if z < 0 else 'up'}"] if z else []
    words += [f"{_mm(length)} along {axis}" for axis, length in zip(AXES, (x, y), strict=False) if length]
    return f"{'rolls' if segment.roll else 'moves'} {' and '.join(words)} {speed}{force}"
