"""Commands of ``ncf-fenicsx study`` on how far a scene can be pushed, and on its error against run time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ncf_fenicsx.scene import Scene
from ncf_fenicsx.terminal import say
from ncf_fenicsx.workers.options import Cluster, Scheduler, Workers

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="Scene file.")]
Overrides = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Replace a value, as stack.layers=2. Repeatable.")
]


def stability_command(
    file: SceneFile,
    out: Annotated[Path | None, typer.Option(help="Folder; results/NAME_stability unless given. Resumed.")] = None,
    overrides: Overrides = None,
    axes: Annotated[
        list[str] | None, typer.Option("--axis", metavar="NAME", help="Run only what begins so. Repeatable.")
    ] = None,
    refinement: Annotated[float, typer.Option(help="Each run is compared with steps this much smaller.", min=1)] = 4,
    limit: Annotated[float, typer.Option(help="Wall time in s after which a run is ended.", min=1)] = 600,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    workers: Workers = None,
) -> None:
    """Push a scene in every direction; a table, and a map of what held and what did not."""
    scene = Scene.read(file, overrides or ())
    from ncf_fenicsx.study.stability import study_stability
    from ncf_fenicsx.study.stability_runner import Runner
    from ncf_fenicsx.workers.cluster import place_for

    folder, texts = out or Path("results") / f"{file.stem}_stability", tuple(overrides or ())
    place = place_for(file, texts, scheduler, cluster, workers, 1)
    say(study_stability(scene, Runner(file, folder, texts, refinement, limit, place), axes))


def error_time_command(
    file: SceneFile,
    out: Annotated[Path | None, typer.Option(help="Folder; results/NAME_error_time unless given. Resumed.")] = None,
    overrides: Overrides = None,
    methods: Annotated[
        list[str] | None, typer.Option("--method", metavar="NAME", help="Run only what begins so. Repeatable.")
    ] = None,
    limit: Annotated[float, typer.Option(help="Wall time in s after which a run is ended.", min=1)] = 3600,
    along_y: Annotated[bool, typer.Option(help="Refine meshes along y too.")] = True,
    levels: Annotated[int, typer.Option(help="Refinements by two that the reference is made of.", min=3)] = 3,
    through: Annotated[bool, typer.Option(help="Refine through the layers too, or take it as the model.")] = True,
) -> None:
    """Weigh error against run time: meshes, steps, contact, tolerances, ranks, explicit; a table and a picture."""
    from ncf_fenicsx.study.error_time import ErrorTime

    folder = out or Path("results") / f"{file.stem}_error_time"
    say(ErrorTime(file, folder, tuple(overrides or ()), limit, along_y, levels, through).run(methods))


def add_to(study: typer.Typer) -> None:
    """Add the commands to those of ``study``."""
    study.command("stability")(stability_command)
    study.command("error-time")(error_time_command)
