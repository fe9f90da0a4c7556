"""Commands of ``ncf-fenicsx study`` that run a scene at many points."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.terminal import say
from ncf_fenicsx.workers.options import Cluster, Ranks, Scheduler, Workers

if TYPE_CHECKING:
    from ncf_fenicsx.sweeps.numerics import Refinement

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="Scene file.")]
Overrides = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Replace a value in all runs. Repeatable.")
]
Varied = Annotated[
    list[str] | None,
    typer.Option("--vary", metavar="KEY=VALUES", help="As laws.shear.modulus=0.5,1,2 MPa or tool.radius=2..5 mm:4."),
]
Limit = Annotated[float, typer.Option(help="Wall time in s after which a run is ended.", min=1)]
Seed = Annotated[int, typer.Option(help="The same one gives the same points.", min=0)]


def sweep_command(
    file: SceneFile,
    varied: Varied = None,
    plan: Annotated[str, typer.Option(help="grid: all with all; latin: a Latin hypercube.")] = "grid",
    count: Annotated[int, typer.Option("--runs", help="Runs of a Latin hypercube.", min=2)] = 50,
    listed: Annotated[
        Path | None, typer.Option("--list", metavar="FILE.csv", help="Points, under keys as tool.radius [mm].")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder; results/NAME_sweep unless given. Resumed.")] = None,
    overrides: Overrides = None,
    limit: Limit = 3600,
    seed: Seed = 1,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    workers: Workers = None,
    ranks: Ranks = 1,
) -> None:
    """Run a scene at many points; a row for each, main effects, and which input carries how much."""
    if bool(varied) == (listed is not None) or plan not in ("grid", "latin"):
        raise SceneError("study sweep: expected either --vary, with --plan grid or latin, or --list FILE.csv")
    from ncf_fenicsx.sweeps import plans
    from ncf_fenicsx.sweeps.campaign import Campaign
    from ncf_fenicsx.sweeps.inputs import read_inputs
    from ncf_fenicsx.sweeps.ranges import parse_vary
    from ncf_fenicsx.sweeps.sweep import inputs_of_list, sweep
    from ncf_fenicsx.workers.cluster import place_for

    texts = tuple(overrides or ())
    place = place_for(file, texts, scheduler, cluster, workers, ranks)
    campaign = Campaign(file, texts, out or Path("results") / f"{file.stem}_sweep", place, limit)
    if listed is not None:
        chosen = plans.listed(campaign.reader, listed)
        inputs = inputs_of_list(chosen)
    else:
        inputs = read_inputs(campaign.reader, [parse_vary(text) for text in varied or ()])
        chosen = plans.grid(inputs) if plan == "grid" else plans.latin(inputs, count, seed)
    say(sweep(campaign, chosen, inputs))


def sensitivity_command(
    file: SceneFile,
    varied: Varied = None,
    method: Annotated[
        str, typer.Option(help="morris: screening; sobol: indices directly; chaos, kriging: by a surrogate.")
    ] = "chaos",
    runs: Annotated[int, typer.Option(help="Runs, at most.", min=1)] = 100,
    out: Annotated[Path | None, typer.Option(help="Folder; results/NAME_sensitivity unless given. Resumed.")] = None,
    overrides: Overrides = None,
    limit: Limit = 3600,
    seed: Seed = 1,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    workers: Workers = None,
    ranks: Ranks = 1,
) -> None:
    """Which inputs move the results: Morris's screening, or Sobol's indices with confidence."""
    from ncf_fenicsx.sweeps.campaign import Campaign
    from ncf_fenicsx.sweeps.inputs import read_inputs
    from ncf_fenicsx.sweeps.ranges import parse_vary
    from ncf_fenicsx.sweeps.sensitivity import Design, sensitivity
    from ncf_fenicsx.workers.cluster import place_for

    if not varied:
        raise SceneError("study sensitivity: expected --vary KEY=LOW..HIGH UNIT, once for each input")
    texts = tuple(overrides or ())
    place = place_for(file, texts, scheduler, cluster, workers, ranks)
    campaign = Campaign(file, texts, out or Path("results") / f"{file.stem}_sensitivity", place, limit)
    parsed = [parse_vary(text) for text in varied]
    for one in parsed:
        if len(one.values) == 1:
            raise SceneError(f"--vary {one.text}: does not vary; expected a range, as LOW..HIGH UNIT, or some values")
    inputs = read_inputs(campaign.reader, parsed)
    say(sensitivity(campaign, inputs, Design.of(method, len(inputs), runs, seed)))


def uncertainty_command(
    file: SceneFile,
    varied: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="KEY=KIND(...)", help="As laws.shear.modulus=normal(1 MPa, 10 %). Repeatable."),
    ] = None,
    fit: Annotated[
        Path | None, typer.Option(metavar="FABRIC.toml", help="Numbers of its laws, with the covariance of their fit.")
    ] = None,
    accuracy: Annotated[
        str | None,
        typer.Option(metavar="SHARE", help="Refine the run in the middle to that, for the numerical error, as '2 %'."),
    ] = None,
    method: Annotated[str, typer.Option(help="direct, or by a surrogate: chaos, kriging.")] = "chaos",
    runs: Annotated[int, typer.Option(help="Runs.", min=1)] = 100,
    out: Annotated[Path | None, typer.Option(help="Folder; results/NAME_uncertainty unless given. Resumed.")] = None,
    overrides: Overrides = None,
    limit: Limit = 3600,
    seed: Seed = 1,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    workers: Workers = None,
    ranks: Ranks = 1,
) -> None:
    """How sure the results are, given how sure the inputs are: distributions of force, Vf, voids and wrinkles."""
    from ncf_fenicsx.sweeps.campaign import Campaign
    from ncf_fenicsx.sweeps.distributions import of_fit, parse_uncertain
    from ncf_fenicsx.sweeps.uncertainty import Draw, uncertainty
    from ncf_fenicsx.workers.cluster import place_for

    if not varied and fit is None:
        raise SceneError("study uncertainty: expected --vary KEY=KIND(NUMBERS), or --fit FABRIC.toml, or both")
    texts = tuple(overrides or ())
    place = place_for(file, texts, scheduler, cluster, workers, ranks)
    campaign = Campaign(file, texts, out or Path("results") / f"{file.stem}_uncertainty", place, limit)
    inputs = [parse_uncertain(campaign.reader, text) for text in varied or ()]
    if fit is not None:
        inputs.append(of_fit(campaign.reader, fit))
    draw = Draw.of(inputs, method, runs, seed)
    say(uncertainty(campaign, draw, None if accuracy is None else refinement(file, texts, accuracy)))


def refinement(file: Path, overrides: tuple[str, ...], accuracy: str) -> Refinement:
    """What the levels of a scene are asked for: a tolerance, as ``2 %`` says it, of what the scene has.

    Raises:
        SceneError: it is no share, or the scene cannot be run by levels.
    """
    from ncf_fenicsx.accuracy.quantities import quantities_of
    from ncf_fenicsx.accuracy.sequence import checked_levels
    from ncf_fenicsx.sweeps.numerics import QUANTITIES, Refinement

    scene = Scene.read(file, (*overrides, "output.companion=false", f"accuracy.tolerance={json.dumps(accuracy)}"))
    assert scene.accuracy is not None
    has = quantities_of(scene)
    asked = Refinement(scene.accuracy.tolerance, tuple(name for name in QUANTITIES.values() if has[name]))
    checked_levels(scene, scene.accuracy.model_copy(update={"quantities": asked.quantities}))
    return asked


def add_to(study: typer.Typer) -> None:
    """Add the commands to those of ``study``."""
    study.command("sweep")(sweep_command)
    study.command("sensitivity")(sensitivity_command)
    study.command("uncertainty")(uncertainty_command)
