"""What a study has found, as a file that its page is drawn from: ``findings.json``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.closing import drawn_or_told
from ncf_fenicsx.report.page import PAGE
from ncf_fenicsx.report.study_page import write_study
from ncf_fenicsx.report.sweep_panels import FINDINGS
from ncf_fenicsx.sweeps.effects import Effect, effects
from ncf_fenicsx.sweeps.estimates import Estimates
from ncf_fenicsx.sweeps.inputs import Input
from ncf_fenicsx.sweeps.interactions import interactions
from ncf_fenicsx.sweeps.outcomes import Measure
from ncf_fenicsx.sweeps.samples import Samples

Floats = NDArray[np.float64]
Found = dict[str, Any]


def write_findings(folder: Path, words: list[str], panels: list[Found]) -> list[str]:
    """Write what a study has found, and the page of its folder; what could not be drawn, a line for each.

    Args:
        folder: of the study, with its rows.
        words: what it comes to, in sentences.
        panels: of `effect_panels`, `estimate_panels` or `distribution_panels`.

    Raises:
        ResultError: the findings cannot be written.
    """
    text = json.dumps({"words": words, "panels": panels}, indent=1) + "\n"
    replace(folder / FINDINGS, lambda beside: beside.write_text(text, encoding="utf-8"))
    return [f"caution: {one}" for one in drawn_or_told(folder, {PAGE: write_study})]


def effect_panels(inputs: list[Input], samples: Samples, measures: list[Measure]) -> list[Found]:
    """Main effects of inputs on results, and what pairs of inputs do together."""
    found = []
    for measure in measures:
        result = _result(measure)
        for one, drawn in zip(inputs, effects(inputs, samples, measure.heading), strict=True):
            found.append({"kind": "effect", **result, **_across(one), "share": drawn.share, "mean": _means(drawn)})
        for pair in interactions(inputs, samples, measure.heading) if len(inputs) > 1 else []:
            lines = {label: _means(drawn) for label, drawn in pair.effects.items()}
            by = _across(pair.second)["input"]
            found.append({"kind": "interaction", **result, **_across(pair.first), "by": by, "lines": lines})
    return found


def estimate_panels(inputs: list[Input], found: dict[Measure, list[Estimates]]) -> list[Found]:
    """Numbers with their confidence: of each result by their names, one for each input."""
    names = [one.name for one in inputs]
    return [
        {"kind": "estimates", **_result(measure), "inputs": names, "numbers": _by_name(estimates)}
        for measure, estimates in found.items()
    ]


def _by_name(estimates: list[Estimates]) -> dict[str, list[tuple[float, float | None, float | None]]]:
    """Value, lower and upper end of each number, one for each input."""
    return {name: [(one[name].value, one[name].low, one[name].high) for one in estimates] for name in estimates[0]}


def distribution_panels(
    drawn: dict[Measure, Floats], found: dict[Measure, Estimates], marked: list[str]
) -> list[Found]:
    """Densities of results in bins, with the numbers of that name marked."""
    panels = []
    for measure, values in drawn.items():
        density, edges = np.histogram(values, bins="auto", density=True)
        marks = {name: found[measure][name].value for name in marked}
        bins = {"edges": edges.tolist(), "density": density.tolist(), "marks": marks}
        panels.append({"kind": "distribution", **_result(measure), **bins})
    return panels


def _result(measure: Measure) -> Found:
    return {"result": measure.words, "column": measure.heading, "unit": measure.unit}


def _across(one: Input) -> Found:
    """What a panel has on its abscissa: the first column of an input, and all of them by name."""
    return {"input": one.name, "across": one.columns[0].heading, "logarithmic": one.logarithmic}


def _means(drawn: Effect) -> Found:
    return {"places": drawn.places.tolist(), "labels": drawn.labels, "values": drawn.means.tolist()}
