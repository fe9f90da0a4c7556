"""A sweep: runs of a plan, their rows, what each input does alone and with others, and one sentence."""

from __future__ import annotations

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.sweeps.campaign import Campaign
from ncf_fenicsx.sweeps.effects import conclusion, effects
from ncf_fenicsx.sweeps.findings import effect_panels, write_findings
from ncf_fenicsx.sweeps.inputs import Input
from ncf_fenicsx.sweeps.outcomes import RESULTS
from ncf_fenicsx.sweeps.parquet import write_parquet
from ncf_fenicsx.sweeps.pictures import draw_effects, draw_interactions, draw_parallel
from ncf_fenicsx.sweeps.plans import Plan
from ncf_fenicsx.sweeps.samples import Samples

LARGEST = 100_000
"""Runs of a plan from which on it is taken for a mistake."""


def sweep(campaign: Campaign, plan: Plan, inputs: list[Input]) -> str:
    """Run what is missing of a plan, and draw what all rows of its inputs say.

    Args:
        campaign: the scene, the folder and the workers.
        plan: which points.
        inputs: what is varied.

    Returns:
        What it comes to.

    Raises:
        SceneError: the plan has too many runs, or the folder holds something else.
    """
    if plan.count > LARGEST:
        raise SceneError(f"study sweep: {plan.count} runs; expected {LARGEST} at most, as by --plan latin")
    campaign.run(plan)
    write_parquet(campaign.rows)
    headings = [measure.heading for measure in RESULTS]
    samples = Samples.read(campaign.rows, [column.heading for column in plan.columns], headings)
    measures = [measure for measure in RESULTS if samples.varies(measure.heading)]
    lines = [samples.in_words]
    if measures:
        draw_effects(inputs, samples, measures, campaign.folder / "effects.png")
        draw_parallel(inputs, samples, measures, campaign.folder / "parallel.png")
        if len(inputs) > 1:
            draw_interactions(inputs, samples, measures[0], campaign.folder / "interactions.png")
        lines += [conclusion(measure.words, effects(inputs, samples, measure.heading)) for measure in measures]
    else:
        lines.append("no result varies from run to run")
    told = write_findings(campaign.folder, lines, effect_panels(inputs, samples, measures))
    return "\n".join([*lines, *told, f"rows, pictures and page in {campaign.folder}"])


def inputs_of_list(plan: Plan) -> list[Input]:
    """A list's columns as inputs, each on its own."""
    points = list(plan.points())
    found = []
    for number, column in enumerate(plan.columns):
        values = tuple(dict.fromkeys((point[number],) for point in points))
        found.append(Input((column,), values))
    return found
