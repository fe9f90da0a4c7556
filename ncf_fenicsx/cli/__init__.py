"""Command line: one function a command, and what a mistake leads to."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from ncf_fenicsx.cli import many_runs, studies
from ncf_fenicsx.cli.usage import call
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import ResultError
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.scene_file import as_written
from ncf_fenicsx.terminal import complain, say, write_any_text
from ncf_fenicsx.version import VERSION

BAD_INPUT, STOPPED, DONE = 2, 1, 0
SIGNALLED = 128
"""Exit code of a program that a signal has ended, less the signal's number."""

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="Scene file.")]
Overrides = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Replace a value, as stack.layers=2. Repeatable.")
]


@app.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """Compaction and wrinkling of dry non-crimp fabric under rigid tools."""
    if version:
        print(VERSION)
        raise typer.Exit


@app.command("run")
def run_command(
    file: Annotated[Path | None, typer.Argument(metavar="[SCENE.toml]", help="Scene file.")] = None,
    out: Annotated[Path | None, typer.Option(help="Results folder; results/NAME unless given.")] = None,
    overrides: Overrides = None,
    overwrite: Annotated[bool, typer.Option(help="Replace results that the folder holds.")] = False,
    restart: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Go on with the run in a results folder, in place of a scene.")
    ] = None,
    accuracy: Annotated[
        str | None, typer.Option(metavar="SHARE", help="Refine until error bars are that small, as '1 %'.")
    ] = None,
    most_time: Annotated[str | None, typer.Option(metavar="TIME", help="Ends that, as '10 min'.")] = None,
    most_memory: Annotated[str | None, typer.Option(metavar="MEMORY", help="Bounds that, as '4 GB'.")] = None,
    companion: Annotated[bool, typer.Option("--companion", help="Run half the mesh too, to tell errors.")] = False,
    ranks: Annotated[int | None, typer.Option(min=1, help="Processes; as many as pay unless given.")] = None,
) -> None:
    """Run a scene. Exit code 0: done; 1: stopped early, last good state saved; 2: bad input, nothing written."""
    from ncf_fenicsx.accuracy.command import Order, carry_out

    wished = {"tolerance": accuracy, "most_time": most_time, "most_memory": most_memory}
    raise typer.Exit(carry_out(Order(file, out, tuple(overrides or ()), overwrite, restart, wished, companion, ranks)))


@app.command("explicit")
def explicit_command(
    file: SceneFile,
    out: Annotated[Path | None, typer.Option(help="Results folder; results/NAME_explicit unless given.")] = None,
    overrides: Overrides = None,
    overwrite: Annotated[bool, typer.Option(help="Replace results that the folder holds.")] = False,
) -> None:
    """March a scene by central differences, to compare with. Exit code 1 also where it was not quasi-static."""
    scene = Scene.read(file, overrides or ())
    from ncf_fenicsx.simulation.explicit import run_explicit

    folder, written = out or Path("results") / f"{file.stem}_explicit", as_written(file, overrides or ())
    result = run_explicit(scene, folder, overwrite=overwrite, written=written)
    say(f"{'done' if result.done else 'stopped'}: {result.reason}; results in {result.folder}")
    raise typer.Exit(DONE if result.done else STOPPED)


@app.command("check")
def check_command(file: SceneFile, overrides: Overrides = None) -> None:
    """Validate a scene; print it with all defaults in SI, what will be built, unknowns and expected memory.

    With automatic divisions it makes the coarse run that finds them.
    """
    scene = Scene.read(file, overrides or ())
    from ncf_fenicsx.accuracy.sequence import plan
    from ncf_fenicsx.simulation.preview import preview

    planned = plan(scene)
    say("\n".join([scene.to_toml(), preview(_meshed(scene)), *planned]))


def _meshed(scene: Scene) -> Scene:
    """The scene on the mesh that a run would take."""
    if not scene.stack.is_automatic:
        return scene
    from mpi4py import MPI

    from ncf_fenicsx.simulation.automatic_mesh import CoarseRunEndedError, with_mesh_in_advance

    try:
        return with_mesh_in_advance(scene, MPI.COMM_WORLD)
    except CoarseRunEndedError as ended:
        say(f"stopped: {ended}")
        raise typer.Exit(STOPPED) from None


@app.command("keys")
def keys_command() -> None:
    """List every key of a scene file with its unit, default and meaning."""
    from ncf_fenicsx.scene.keys import reference

    say(reference())


@app.command("fabrics")
def fabrics_command() -> None:
    """List the fabrics that ship, with the source of their numbers."""
    from ncf_fenicsx.scene.fabric_file import list_fabrics

    say(list_fabrics())


@app.command("compare")
def compare_command(
    history: Annotated[Path, typer.Argument(metavar="HISTORY.csv", help="What is judged, of any code.")],
    reference: Annotated[Path, typer.Argument(metavar="REFERENCE.csv", help="What it is held against.")],
    tolerance: Annotated[float, typer.Option(help="Allowed share of a column's largest size.", min=0)] = 0.02,
    columns: Annotated[
        list[str] | None, typer.Option("--column", metavar="NAME", help="Compare only this column. Repeatable.")
    ] = None,
    over: Annotated[str, typer.Option(metavar="NAME", help="Column that curves are drawn over.")] = "time",
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw both histories there.")] = None,
) -> None:
    """Hold a history against another one. Exit code 0: within the tolerance; 1: not; 2: bad input."""
    from ncf_fenicsx.study.comparison import Comparison, Curves

    if picture is not None and (picture.suffix != ".png" or not picture.parent.is_dir()):
        raise SceneError(f"--picture {picture}: expected a file that ends with .png, in a folder that exists")
    comparison = Comparison(Curves.read(history), Curves.read(reference), columns, over)
    say(comparison.table(tolerance))
    if picture is not None:
        comparison.draw(picture)
    raise typer.Exit(DONE if comparison.within(tolerance) else STOPPED)


@app.command("crosscheck")
def crosscheck_command(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Histories of another code, NAME.csv.")],
    kit: Annotated[Path, typer.Option(help="Folder of the cases.")] = Path("demos/crosscheck"),
    tolerance: Annotated[float | None, typer.Option(help="Share of a column's largest size.", min=0)] = None,
) -> None:
    """Judge another code by the cross-check kit. Exit code 0: what it gave has passed; 1: not; 2: bad input."""
    from ncf_fenicsx.study.crosscheck import holds, judge, table

    say(table(verdicts := judge(folder, kit, tolerance)))
    raise typer.Exit(DONE if holds(verdicts) else STOPPED)


@app.command("report")
def report_command(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Results folders, or one folder of a study.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="Page of several folders; comparison.html unless given.")
    ] = None,
) -> None:
    """Write a page that opens without a network: DIR/report.html, also of an unfinished run; or one to compare runs."""
    if out is not None and (len(folders) == 1 or out.suffix != ".html" or not out.absolute().parent.is_dir()):
        expected = "a file that ends with .html, in a folder that exists, for two results folders or more"
        raise SceneError(f"--out {out}: expected {expected}")
    from ncf_fenicsx.report.comparison_page import write_comparison
    from ncf_fenicsx.report.page import write_report
    from ncf_fenicsx.report.study_page import is_study, write_study

    if len(folders) > 1:
        say(f"page in {write_comparison(folders, out or Path('comparison.html'))}")
    else:
        say(f"page in {(write_study if is_study(folders[0]) else write_report)(folders[0])}")


@app.command("export")
def export_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Results folder.")],
    to: Annotated[str, typer.Option(metavar="FORMAT", help="abaqus, calculix, vtkhdf, lcmsim or csv.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the files; DIR/export unless given.")] = None,
    time: Annotated[str | None, typer.Option(metavar="TIME", help="Step nearest to it; else the last.")] = None,
) -> None:
    """Write the deformed stack for other programs: mesh, fields, thickness, porosity, permeability."""
    from ncf_fenicsx.export.command import Order, carry_out

    say(carry_out(Order(folder, to, out, time)))


@app.command("watch")
def watch_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Results folder that a run writes to.")],
    every: Annotated[float, typer.Option(metavar="SECONDS", help="Time between two looks.", min=0.1)] = 1.0,
) -> None:
    """Show force, Vf, contact and step size of a run that goes on in another terminal, until it ends."""
    from ncf_fenicsx.report.watch import watch

    watch(folder, every)


@app.command("benchmark")
def benchmark_command(
    file: Annotated[Path | None, typer.Argument(metavar="[SCENE.toml]", help="Measure a run of this scene.")] = None,
    overrides: Overrides = None,
    divisions: Annotated[int, typer.Option(help="Elements along x and y of each of four layers.", min=1)] = 32,
) -> None:
    """Measure what the laws cost on this machine, on one rank; or what a scene's run costs, over one factorisation."""
    if file is not None:
        from ncf_fenicsx.study.run_cost import benchmark_run

        say(benchmark_run(Scene.read(file, overrides or ())))
    else:
        from ncf_fenicsx.study.law_cost import benchmark

        say(benchmark(divisions))


@app.command("calibrate")
def calibrate_command(
    files: Annotated[list[Path], typer.Argument(metavar="DATA.csv ...", help="Files of testing machines.")],
    laws: Annotated[
        list[str] | None, typer.Option("--law", metavar="FAMILY=KIND", help="Law to fit; auto lets a criterion choose.")
    ] = None,
    given: Annotated[
        list[str] | None, typer.Option("--given", metavar="[FILE:]KEY=VALUE", help="What a specimen was. Repeatable.")
    ] = None,
    free: Annotated[list[str] | None, typer.Option("--free", metavar="NAME", help="Number to fit too.")] = None,
    fixed: Annotated[list[str] | None, typer.Option("--fix", metavar="NAME", help="Number not to fit.")] = None,
    compliance: Annotated[str, typer.Option(help="Of the machine, as '1e-7 m/N', or fit.")] = "0 m/N",
    slack: Annotated[str, typer.Option(help="Travel before the specimen is touched, or fit.")] = "0 mm",
    weight: Annotated[str, typer.Option(help="thickness (at given pressure), or pressure.")] = "thickness",
    title: Annotated[str, typer.Option(help="Name of the fabric.")] = "calibrated fabric",
    out: Annotated[Path | None, typer.Option(metavar="FABRIC.toml", help="Write the fabric there.")] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the laws over the data there.")] = None,
    page: Annotated[Path | None, typer.Option(metavar="FILE.html", help="A page of the fit.")] = None,
    check: Annotated[bool, typer.Option(help="Simulate the tests with the fitted fabric; exit code 1 if off.")] = False,
) -> None:
    """Fit laws to the files of testing machines, with errors; a fabric file with the source of each number."""
    from ncf_fenicsx.calibration.command import Order, carry_out

    machine = {"compliance": compliance, "slack": slack}
    wishes = (files, laws or [], given or [], free or [], fixed or [], machine, weight)
    order = Order(*wishes, title, out, picture, check, page)
    words, holds = carry_out(order)
    say(words)
    raise typer.Exit(DONE if holds else STOPPED)


study = typer.Typer(no_args_is_help=True, help="Many runs of a scene: how far it can be pushed, and what moves it.")
app.add_typer(study, name="study")
studies.add_to(study)
many_runs.add_to(study)


def _end(number: int, frame: FrameType | None) -> None:
    del frame
    sys.exit(SIGNALLED + number)


def main() -> None:
    """Entry point; every user's mistake is one line and exit code 2, and a rank that fails ends all ranks."""
    write_any_text()
    if os.getpid() == 1:
        signal.signal(signal.SIGTERM, _end)  # the first process of a container does not end on it unless it says so
    try:
        for argument in sys.argv:
            argument.encode()  # DOLFINx does not start with one that the locale cannot read
        sys.exit(call(app))
    except SceneError as error:
        complain(str(error))
        sys.exit(BAD_INPUT)
    except UnicodeEncodeError as error:
        complain(f"{error.object}: has letters that this locale does not know; expected LC_ALL=C.UTF-8 or PYTHONUTF8=1")
        sys.exit(BAD_INPUT)
    except ResultError as error:
        complain(str(error))
        sys.exit(STOPPED)
    except KeyboardInterrupt:
        from mpi4py import MPI

        complain("interrupted")
        MPI.COMM_WORLD.Abort(STOPPED)
    except Exception:
        traceback.print_exc()
        from mpi4py import MPI

        MPI.COMM_WORLD.Abort(STOPPED)
