"""Panels of a sequence of runs to an accuracy: each quantity with its bar over what the levels have cost."""

from __future__ import annotations

from typing import Any

from ncf_fenicsx.report.sentence import short
from ncf_fenicsx.report.study_panels import Panel, line, panel

COST = "run time of the level in s, without compiling forms"
HEAD = ("level", "unknowns", "run time (s)", "peak memory (MB)", "loses stability at (s)")


def sequence_panels(answer: dict[str, Any]) -> list[Panel]:
    """A panel for each quantity.

    Args:
        answer: contents of ``accuracy.json``.
    """
    levels, tolerance = answer["levels"], answer["asked"]["tolerance"]
    panels = []
    for name, one in answer["quantities"].items():
        by_value = all(name in level["values"] for level in levels)
        panels.append((_values if by_value else _bars)(name, one, levels, tolerance))
    return panels


def _values(name: str, one: dict[str, Any], levels: list[dict[str, Any]], tolerance: float) -> Panel:
    """Value and bar of each level, with what was asked for and the limit that values tend to."""
    factor, unit = one["factor_to_unit"], one["unit"]
    points = []
    for level in levels:
        value, bar = factor * level["values"][name], level["bars"][name]
        half = None if bar is None else factor * bar
        ends = () if half is None else (value - half, value + half)
        points.append((level["seconds"], value, f"level {level['level']}", *ends))
    lines = [line("levels, with their bars", points, bars=True)]
    times, finest = [level["seconds"] for level in levels], factor * one["value"]
    if len(set(times)) > 1:
        room = tolerance * abs(finest)
        asked = f"asked: +- {short(100 * tolerance)} %"
        span = [(time, finest, "", finest - room, finest + room) for time in (min(times), max(times))]
        lines.append(line(asked, span))
        if one["limit"] is not None:
            limit = factor * one["limit"]
            lines.append(line("extrapolated", [(time, limit, "") for time in (min(times), max(times))]))
    title = one["title"][0].upper() + one["title"][1:]
    words = f"{one['title']} in {unit}" if unit else one["title"]
    return panel(title, COST, words, lines, logarithmic="x", note=one["words"] + ".")


def _bars(name: str, one: dict[str, Any], levels: list[dict[str, Any]], tolerance: float) -> Panel:
    """Length of the bar at each level, over the size of the quantity: of a field that has no one value."""
    known = [(level, level["bars"][name]) for level in levels if level["bars"][name] is not None and one["value"]]
    points = [(level["seconds"], 100 * bar / one["value"], f"level {level['level']}") for level, bar in known]
    lines = [line("error bars", points)]
    if len(points) > 1:
        times = [point[0] for point in points]
        lines.append(line("asked", [(time, 100 * tolerance, "") for time in (min(times), max(times))]))
    title = one["title"][0].upper() + one["title"][1:]
    return panel(f"{title}: error bar", COST, "bar in %", lines, logarithmic="x", note=one["words"] + ".")


def level_rows(answer: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of a table of the levels: what each cost, and its values with their bars."""
    shown = answer["quantities"]
    head = [*HEAD, *(f"{one['title']} ({one['unit']})" if one["unit"] else one["title"] for one in shown.values())]
    rows = []
    for level in answer["levels"]:
        lost = level["stability_lost_at"]
        cost = [level["level"], level["unknowns"], short(level["seconds"]), f"{level['peak_memory_mb']:.0f}"]
        cells = [_cell(level, name, one["factor_to_unit"]) for name, one in shown.items()]
        rows.append([*map(str, cost), "never" if lost is None else short(lost), *cells])
    return head, rows


def _cell(level: dict[str, Any], name: str, factor: float) -> str:
    """Value and bar of a quantity at a level."""
    value, bar = level["values"].get(name), level["bars"][name]
    words = "" if value is None else f"{factor * value:.5g} "
    return words + ("without a bar yet" if bar is None else f"+- {factor * bar:.2g}")
