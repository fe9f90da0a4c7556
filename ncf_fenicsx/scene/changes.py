"""What may change in a scene when a run of it goes on from a time: how it is solved and written, and what is to come.

All else is in the state that the run goes on from.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.scene.scene import Scene
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.path import Segment
from ncf_fenicsx.tools.rigid_surface import Tool

FREE = ("title", "solver", "output", "duration")
"""Keys and tables that a restart may change; what is yet to come of ``tool.path`` too."""
ALLOWED = "a restart may change title, solver, output, and what is yet to come of tool.path or duration"
SAME = 1e-9
"""Difference of two times or lengths, over their size, that is round-off."""


def check_changes(old: Scene, new: Scene, time: float, source: str) -> None:
    """Whether a run of a scene may go on as another scene.

    Args:
        old: scene of the run.
        new: scene that it shall go on with.
        time: that it goes on from in s.
        source: where the run is, for messages.

    Raises:
        SceneError: a key is changed that no restart may change; it is named with both values.
    """
    for key, before, now in _differences(_table(old), _table(new), ""):
        if key.split(".")[0] not in FREE:
            raise SceneError(f"{source}: {key} = {_shown(now)}: {ALLOWED}; expected {_shown(before)}")
    end = new.milestones[-1]
    if end < time * (1 - SAME):
        key = "tool.path" if new.tool else "duration"
        raise SceneError(f"{source}: {key} ends at {end:.6g} s; expected an end at {time:.6g} s, where it is, or later")
    for number, (tool, longer) in enumerate(zip(old.tool, new.tool, strict=True)):
        _check_path(
            tool, longer, time, f"{source}: tool.{number}.path" if len(old.tool) > 1 else f"{source}: tool.path"
        )
    if not math.isclose(old.natural_stiffness, new.natural_stiffness, rel_tol=SAME):
        fastest = 6e4 * max((segment.closing_speed for segment in old.segments), default=0.0)
        words = f"expected {fastest:.6g} mm/min to stay the highest speed downwards, which contact stiffness follows"
        raise SceneError(f"{source}: tool.path: {words}")


def _table(scene: Scene) -> dict[str, Any]:
    """Table of a scene as it reads back, without what is compared on its own."""
    table = Scene.from_table(tomllib.loads(scene.to_toml())).table()
    tools = table.get("tool", [])
    for tool in [tools] if isinstance(tools, dict) else tools:
        tool.pop("path", None)
    return table


def _differences(old: Any, new: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Dotted keys whose values differ, with both; None for a key that is not there."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in [*old, *(name for name in new if name not in old)]:
            yield from _differences(old.get(name), new.get(name), f"{key}.{name}" if key else name)
    elif _is_tables(old) and _is_tables(new) and len(old) == len(new):
        for number, (before, now) in enumerate(zip(old, new, strict=True)):
            yield from _differences(before, now, f"{key}.{number}")
    elif old != new:
        yield key, old, new


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, dict) for item in value)


def _shown(value: Any) -> str:
    if value is None:
        return "none"
    text = "another table" if isinstance(value, dict) or (value and _is_tables(value)) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _check_path(old: Tool, new: Tool, time: float, key: str) -> None:
    """Whether two paths of a tool agree up to a time (s)."""
    if old.under_force != new.under_force:
        raise SceneError(f"{key}: expected forces only if the path has had some from its start")
    ends = [0.0, *motion.milestones(old.path)]
    for number, (start, end) in enumerate(pairwise(ends)):
        if start >= time * (1 - SAME):
            return
        segment = old.path[number]
        other = new.path[number] if number < len(new.path) else None
        past = end < time * (1 - SAME)
        fits = other == segment or (other is not None and not past and _goes_on(old.path, number, other, time - start))
        if not fits:
            words = "has been travelled" if past else f"has been travelled for {time - start:.6g} s"
            allowed = "it as it was" if past else "it as it was, or longer: the same way, speed and force"
            raise SceneError(f"{key}.{number}: {words}; expected {allowed}")


def _goes_on(path: tuple[Segment, ...], number: int, other: Segment, travelled: float) -> bool:
    """Whether a segment is one of a path for the time (s) that this has been travelled, although longer or shorter."""
    segment = path[number]
    force_before = path[number - 1].force if number else None
    if (segment.force, segment.roll) != (other.force, other.roll) or other.duration < travelled * (1 - SAME):
        return False
    if segment.force is not None and segment.force != force_before:
        return False  # the ramp would have been another one
    ways = [_velocity(part) for part in (segment, other)]
    return math.dist(*ways) <= SAME * math.hypot(*ways[0])


def _velocity(segment: Segment) -> list[float]:
    """Of the tool along x, y and z in m/s."""
    return [length / segment.duration for length in segment.travel or (0.0, 0.0, 0.0)]
