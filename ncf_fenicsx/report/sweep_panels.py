"""Panels of a study that has run a scene at many points: its runs, and what it has found in them.

Effects, indices and distributions are those of ``findings.json``; nothing is estimated here.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

from ncf_fenicsx.parameters.units import parse_number
from ncf_fenicsx.report.study_panels import Panel, Point, Row, line, panel
from ncf_fenicsx.report.thinning import evenly

FINDINGS = "findings.json"
RUN = "run"
"""Column between inputs and results."""
MOST_LINES = 1000
"""Runs that are drawn across parallel axes, and rows of the table."""

Found = dict[str, Any]


def headings(rows: list[Row]) -> tuple[list[str], list[str]]:
    """Headings of the inputs and of the results, ending and reason not among them."""
    names = list(rows[0]) if rows else [RUN]
    place = names.index(RUN)
    return names[:place], names[place + 1 : -2]


def sweep_panels(rows: list[Row], findings: list[Found]) -> list[Panel]:
    """Panels of what was found, a group for each result; of a study that has not ended its runs alone.

    Args:
        rows: of the runs, numbers in SI.
        findings: panels of ``findings.json``, none of a study that has not ended.
    """
    if findings:
        return [KINDS[one["kind"]](one, rows) for one in findings]
    inputs, results = headings(rows)
    return [_runs(rows, one, result) for result in results for one in inputs if _numbers(rows, one)]


def _numbers(rows: list[Row], column: str) -> bool:
    return all(parse_number(row[column]) is not None for row in rows)


def _runs(rows: list[Row], across: str, result: str) -> Panel:
    """A result of runs over an input that is a number."""
    points = _points(rows, across, result, None)
    return panel(f"{result} over {across}", across, result, [line("run", points, apart=True)], group=result)


def _points(rows: list[Row], across: str, result: str, labels: list[str] | None) -> list[Point]:
    """Runs that have a result, by their place along an input: its number, or that of its label, counted from 1."""
    found: list[Point] = []
    for row in rows:
        x = parse_number(row[across])
        if labels is not None:
            x = labels.index(row[across]) + 1.0 if row[across] in labels else None
        if row[result] and x is not None:
            found.append((x, float(row[result]), row[RUN]))
    return sorted(found, key=lambda point: point[:2])


def _titled(one: Found) -> dict[str, Any]:
    """Words at the axes and the group of a finding."""
    unit = f" ({one['unit']})" if one["unit"] else ""
    return {"y": f"{one['result']}{unit}", "group": one["result"]}


def _named(one: Found, rows: list[Row]) -> list[str] | None:
    """Labels of the levels of an input that is no number; None of one that is."""
    labels: list[str] = one["mean"]["labels"]
    return None if _numbers(rows, one["across"]) else labels


def _effect(one: Found, rows: list[Row]) -> Panel:
    """Runs and means over an input, with the share of the variance that the means carry."""
    labels = _named(one, rows)
    runs = line("run", _points(rows, one["across"], one["column"], labels), apart=True)
    means = line("mean", _means(one["mean"], labels), front=True)
    title = f"{one['input']}: {100 * one['share']:.0f} % of the variance of the {one['result']}"
    return panel(title, one["across"], lines=[runs, means], **_titled(one), **_axis(one, labels))


def _axis(one: Found, labels: list[str] | None) -> dict[str, Any]:
    """Names of the places of words; else whether the axis is logarithmic."""
    if labels is not None:
        return {"names": labels}
    return {"logarithmic": "x"} if one["logarithmic"] else {}


def _means(mean: Found, labels: list[str] | None) -> list[Point]:
    places = mean["places"] if labels is None else [labels.index(name) + 1.0 for name in mean["labels"]]
    return [(x, y, "") for x, y in zip(places, mean["values"], strict=True)]


def _interaction(one: Found, rows: list[Row]) -> Panel:
    """Means over one input, a line for each level of another."""
    labels = None
    if not _numbers(rows, one["across"]):
        labels = list(dict.fromkeys(name for mean in one["lines"].values() for name in mean["labels"]))
    lines = [line(f"{one['by']} {name}", _means(mean, labels)) for name, mean in one["lines"].items()]
    note = "Parallel lines do not interact."
    title = f"{one['input']} with {one['by']}"
    return panel(title, one["across"], lines=lines, note=note, **_titled(one), **_axis(one, labels))


def _estimates(one: Found, rows: list[Row]) -> Panel:
    """Numbers of each input with their confidence, side by side."""
    del rows
    lines, count = [], len(one["numbers"])
    for place, (name, numbers) in enumerate(one["numbers"].items()):
        beside = 0.5 * ((place + 0.5) / count - 0.5)
        points: list[Point] = []
        for number, (value, low, high) in enumerate(numbers, start=1):
            ends = () if low is None else (low, high)
            points.append((number + beside, value, one["inputs"][number - 1], *ends))
        lines.append(line(name, points, apart=True, bars=True))
    shares = "first" in one["numbers"]
    y = "share of the variance" if shares else f"{one['result']} ({one['unit']})" if one["unit"] else one["result"]
    note = "Bars are 95 % intervals."
    title = one["result"][0].upper() + one["result"][1:]
    return panel(title, "input", y, lines, names=one["inputs"], note=note)


def _distribution(one: Found, rows: list[Row]) -> Panel:
    """Density of a result as steps, with lines at some of its values."""
    del rows
    steps: list[Point] = [(one["edges"][0], 0.0, "")]
    for (low, high), density in zip(pairwise(one["edges"]), one["density"], strict=True):
        steps += [(low, density, ""), (high, density, "")]
    steps.append((one["edges"][-1], 0.0, ""))
    top = max(one["density"])
    marks = [line(name, [(value, 0.0, ""), (value, top, "")], traced=True) for name, value in one["marks"].items()]
    unit = f" ({one['unit']})" if one["unit"] else ""
    title = one["result"][0].upper() + one["result"][1:]
    return panel(title, f"{one['result']}{unit}", "density", [line("density", steps, traced=True), *marks])


KINDS: dict[str, Callable[[Found, list[Row]], Panel]] = {
    "effect": _effect,
    "interaction": _interaction,
    "estimates": _estimates,
    "distribution": _distribution,
}
"""What makes a panel of each kind of finding."""


def parallel(rows: list[Row]) -> dict[str, Any]:
    """Runs that are done as lines across axes of all inputs and results, at most `MOST_LINES` of them.

    Returns:
        Axes with heading, words of their places if they are no numbers, and values; names of the runs.
    """
    inputs, results = headings(rows)
    done = [row for row in rows if row[results[0]]] if results else []
    shown = [done[place] for place in evenly(len(done), MOST_LINES)]
    axes: list[dict[str, Any]] = []
    for heading in (*inputs, *results):
        numbers = [parse_number(row[heading]) for row in shown]
        words = sorted({row[heading] for row in shown})
        if any(one is None for one in numbers) and all(row[heading] for row in shown):
            axes.append({"heading": heading, "words": words, "values": [words.index(row[heading]) for row in shown]})
        elif any(one is not None for one in numbers):
            axes.append({"heading": heading, "words": None, "values": numbers})
    coloured = sum(axis["heading"] in inputs for axis in axes)
    return {"axes": axes, "runs": [row[RUN] for row in shown], "of": len(done), "coloured": coloured}
