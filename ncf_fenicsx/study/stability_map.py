"""The map of a stability study: a line for each property, a field for each value, what happened in it."""

from __future__ import annotations

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from ncf_fenicsx.workers.rows import Row

COLOURS = {
    "done": "#a6d96a",
    "done, stability lost on the way": "#fee08b",
    "done, force off its reference by over 1 %": "#fdae61",
    "stopped, with its reason": "#d7301f",
    "time limit or error": "#969696",
}
ACCURATE = 0.01


def verdict(row: Row) -> str:
    """What happened in a run, one of `COLOURS`."""
    if row["ending"] == "stopped":
        return "stopped, with its reason"
    if row["ending"] != "done":
        return "time limit or error"
    if row["difference"] and abs(float(row["difference"])) > ACCURATE:
        return "done, force off its reference by over 1 %"
    return "done, stability lost on the way" if row["stability_lost_s"] else "done"


def draw_map(rows: list[Row], title: str, path: Path) -> None:
    """Draw the map."""
    axes_names = list(dict.fromkeys(row["axis"] for row in rows))
    widest = max(sum(row["axis"] == name for row in rows) for name in axes_names)
    figure = Figure(figsize=(3.2 + 1.25 * widest, 1.4 + 0.62 * len(axes_names)), layout="constrained")
    axes = figure.subplots()
    for line, name in enumerate(axes_names):
        for column, row in enumerate(row for row in rows if row["axis"] == name):
            axes.add_patch(Rectangle((column, -line), 0.96, 0.9, color=COLOURS[verdict(row)]))
            cost = f"{row['iterations']} it, {row['cuts']} cuts" if row["iterations"] else row["ending"]
            axes.text(column + 0.48, -line + 0.62, row["value"], ha="center", va="center", weight="bold", fontsize=9)
            axes.text(column + 0.48, -line + 0.27, cost, ha="center", va="center", fontsize=7)
    axes.set(xlim=(0, widest), ylim=(1 - len(axes_names), 1), title=title)
    axes.set_yticks([0.45 - line for line in range(len(axes_names))], axes_names)
    axes.set_xticks([])
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    used = {verdict(row) for row in rows}
    handles = [Patch(color=colour, label=label) for label, colour in COLOURS.items() if label in used]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    FigureCanvasAgg(figure).print_png(path)
