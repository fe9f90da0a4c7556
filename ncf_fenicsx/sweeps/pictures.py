"""Pictures of a sweep: main effects, what two inputs do together, and all runs as lines across parallel axes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ncf_fenicsx.sweeps.effects import Effect, effects
from ncf_fenicsx.sweeps.estimates import Estimates
from ncf_fenicsx.sweeps.inputs import Input, number_of
from ncf_fenicsx.sweeps.interactions import interactions
from ncf_fenicsx.sweeps.outcomes import Measure
from ncf_fenicsx.sweeps.samples import Samples
from ncf_fenicsx.workers.rows import Point

Floats = NDArray[np.float64]


def draw_effects(inputs: list[Input], samples: Samples, measures: list[Measure], path: Path) -> None:
    """Draw the runs and the mean at each level, a row of fields for each result, a column for each input."""
    figure = Figure(figsize=(1.5 + 3.2 * len(inputs), 0.6 + 2.6 * len(measures)), layout="constrained")
    fields: Any = figure.subplots(len(measures), len(inputs), squeeze=False, sharey="row")
    parts = samples.of(inputs)
    for line, measure in enumerate(measures):
        found = effects(inputs, samples, measure.heading)
        for axes, one, levels, drawn in zip(fields[line], inputs, parts, found, strict=True):
            axes.plot(_places(levels), samples.values[measure.heading], "o", ms=3, alpha=0.35, color="tab:grey")
            _draw_means(axes, one, drawn, "tab:blue")
            axes.set_title(f"{100 * drawn.share:.0f} % of the variance", fontsize=9)
            axes.set_xlabel(_heading(one))
        fields[line][0].set_ylabel(f"{measure.words}{_unit(measure)}")
    FigureCanvasAgg(figure).print_png(path)


def draw_interactions(inputs: list[Input], samples: Samples, measure: Measure, path: Path) -> None:
    """Draw means over one input, a line for each level of another: parallel where the two do not interact."""
    found = interactions(inputs, samples, measure.heading)
    wide = min(len(found), 3)
    figure = Figure(figsize=(4.4 * wide, 3.4 * -(-len(found) // wide)), layout="constrained")
    fields: Any = figure.subplots(-(-len(found) // wide), wide, squeeze=False).ravel()
    for axes, pair in zip(fields, found, strict=False):
        for label, drawn in pair.effects.items():
            _draw_means(axes, pair.first, drawn, None, label)
        axes.legend(title=_heading(pair.second), fontsize=7, title_fontsize=8, frameon=False)
        axes.set(xlabel=_heading(pair.first), ylabel=f"{measure.words}{_unit(measure)}")
    for spare in fields[len(found) :]:
        spare.remove()
    FigureCanvasAgg(figure).print_png(path)


def draw_parallel(inputs: list[Input], samples: Samples, measures: list[Measure], path: Path) -> None:
    """Draw each run as a line across axes of all inputs and results, coloured by the first result."""
    columns = [_places(levels) for levels in samples.of(inputs)]
    columns += [samples.values[measure.heading] for measure in measures]
    names = [_heading(one) for one in inputs] + [f"{measure.words}{_unit(measure)}" for measure in measures]
    scaled = np.array([_to_unit(column) for column in columns])
    figure = Figure(figsize=(1.5 + 1.9 * len(columns), 4.6), layout="constrained")
    axes = figure.subplots()
    for run in range(scaled.shape[1]):
        shade = scaled[len(inputs), run]
        if np.isfinite(shade):
            axes.plot(scaled[:, run], lw=0.8, alpha=0.6, color=colormaps["viridis"](shade))
    for place, column in enumerate(columns):
        axes.axvline(place, color="black", lw=0.8)
        for height, value in ((-0.04, np.nanmin(column)), (1.02, np.nanmax(column))):
            axes.text(place, height, f"{value:.4g}", ha="center", va="top" if height < 0 else "bottom", fontsize=8)
    axes.set_xticks(range(len(columns)), names, rotation=20, ha="right", fontsize=8)
    axes.set(yticks=[], ylim=(-0.12, 1.1))
    for spine in axes.spines.values():
        spine.set_visible(False)
    FigureCanvasAgg(figure).print_png(path)


def draw_estimates(inputs: list[Input], found: dict[Measure, list[Estimates]], path: Path) -> None:
    """Draw bars with their confidence, a field for each result, a group of bars for each input."""
    figure = Figure(figsize=(3 + 1.5 * len(inputs), 0.8 + 2.6 * max(len(found), 1)), layout="constrained")
    fields: Any = figure.subplots(max(len(found), 1), squeeze=False, sharex=True)[:, 0]
    for axes, (measure, estimates) in zip(fields, found.items(), strict=False):
        names = list(estimates[0])
        for number, name in enumerate(names):
            own = [one[name] for one in estimates]
            places = np.arange(len(inputs)) + 0.8 * ((number + 0.5) / len(names) - 0.5)
            values = np.array([one.value for one in own])
            ends = np.array([(one.value if one.low is None else one.low, one.high or one.value) for one in own]).T
            bars = np.abs(ends - values)
            axes.bar(places, values, 0.8 / len(names), yerr=bars, capsize=2, label=name)
        axes.axhline(0.0, color="black", lw=0.8)
        axes.set_title(measure.words, fontsize=10)
        axes.set_ylabel("share of the variance" if "first" in names else measure.unit)
        axes.legend(fontsize=8, frameon=False)
    fields[-1].set_xticks(range(len(inputs)), [one.name for one in inputs], rotation=20, ha="right")
    FigureCanvasAgg(figure).print_png(path)


def draw_distributions(drawn: dict[Measure, Floats], found: dict[Measure, Estimates], path: Path) -> None:
    """Draw how each result is distributed, with its median and where 90 of 100 cases are."""
    figure = Figure(figsize=(6.4, 0.6 + 2.6 * max(len(drawn), 1)), layout="constrained")
    fields: Any = figure.subplots(max(len(drawn), 1), squeeze=False)[:, 0]
    for axes, (measure, values) in zip(fields, drawn.items(), strict=False):
        axes.hist(values, bins="auto", density=True, color="tab:blue", alpha=0.5)
        for name in ("5 %", "median", "95 %"):
            axes.axvline(found[measure][name].value, color="black", lw=2 if name == "median" else 1)
        axes.set(xlabel=f"{measure.words}{_unit(measure)}", ylabel="density")
    FigureCanvasAgg(figure).print_png(path)


def _draw_means(axes: Any, one: Input, drawn: Effect, colour: str | None, label: str | None = None) -> None:
    axes.plot(drawn.places, drawn.means, "o-", lw=2, color=colour, label=label)
    if not all(np.isfinite(number_of(value)) for level in one.levels for value in level[:1]):
        axes.set_xticks(drawn.places, drawn.labels)
    elif one.logarithmic:
        axes.set_xscale("log")


def _places(levels: list[Point]) -> Floats:
    """Where values stand on an axis: numbers as they are, words one after the other."""
    numbers = np.array([number_of(level[0]) for level in levels])
    if np.isfinite(numbers).all():
        return numbers
    order = {level: place for place, level in enumerate(sorted(set(levels)))}
    return np.array([float(order[level]) for level in levels])


def _to_unit(column: Floats) -> Floats:
    low, high = np.nanmin(column), np.nanmax(column)
    return (column - low) / (high - low) if high > low else np.where(np.isfinite(column), 0.5, np.nan)


def _heading(one: Input) -> str:
    return "\n".join(column.heading for column in one.columns)


def _unit(measure: Measure) -> str:
    return f" ({measure.unit})" if measure.unit else ""
