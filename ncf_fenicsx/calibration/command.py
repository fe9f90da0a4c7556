"""``ncf-fenicsx calibrate``: what was asked for in texts, checked before anything is written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

from mpi4py import MPI

from ncf_fenicsx.calibration import check as checking
from ncf_fenicsx.calibration.calibrate import Wishes, calibrate, wished_kinds
from ncf_fenicsx.calibration.fabric_writer import fabric_table, in_words, to_toml
from ncf_fenicsx.calibration.fitting import MACHINE, Weight
from ncf_fenicsx.calibration.page import write_page
from ncf_fenicsx.calibration.plots import draw, panels
from ncf_fenicsx.calibration.specimens import Machine, given_values
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.parameters.units import parse_quantity


@dataclass(frozen=True)
class Order:
    """What the command line asks for, as texts."""

    files: list[Path]
    laws: list[str]
    given: list[str]
    free: list[str]
    fixed: list[str]
    machine: dict[str, str]
    weight: str
    title: str
    out: Path | None
    picture: Path | None
    check: bool
    page: Path | None = None


def carry_out(order: Order) -> tuple[str, bool]:
    """Words on the fit, and whether runs with it give the tests back (if that was asked for).

    Raises:
        SceneError: something asked for, or a file, is wrong; nothing is written then.
    """
    if MPI.COMM_WORLD.size > 1:
        raise SceneError(f"calibrate: on {MPI.COMM_WORLD.size} ranks; expected one, without mpirun")
    for option, path, suffix in _files(order):
        if path is not None and (path.suffix != suffix or not path.parent.is_dir()):
            raise SceneError(f"{option} {path}: expected a file that ends with {suffix}, in a folder that exists")
    made = calibrate(order.files, given_values(order.given), _wishes(order))
    words, holds = in_words(made), True
    if order.check:
        if made.fit is None:
            raise SceneError("--check: expected tests of compaction, which are what is simulated")
        checked = checking.check(made.fit, made.tests)
        words, holds = f"{words}\n{checking.in_words(checked)}", all(test.holds for test in checked)
    if order.out is not None:
        text = to_toml(fabric_table(made, order.title))
        replace(order.out, lambda path: _write(path, text))
    if order.picture is not None:
        replace(order.picture, lambda path: draw(panels(made), path))
    if order.page is not None:
        write_page(order.page, order.title, words, panels(made))
    return words, holds


def _files(order: Order) -> list[tuple[str, Path | None, str]]:
    """Options that name a file, with its name and how that has to end."""
    return [("--out", order.out, ".toml"), ("--picture", order.picture, ".png"), ("--page", order.page, ".html")]


def _write(path: Path, text: str) -> None:
    path.write_text(text, "utf-8")


def _wishes(order: Order) -> Wishes:
    if order.weight not in ("thickness", "pressure"):
        raise SceneError(f"--weight {order.weight}: expected thickness or pressure")
    known, fitted = {}, []
    for key, text in order.machine.items():
        symbol = MACHINE[f"machine.{key}"]
        if text == "fit":
            fitted.append(f"machine.{key}")
            continue
        value = parse_quantity(text, symbol)
        if value is None or value < 0:
            raise SceneError(f"--{key} {text}: expected a value of at least 0 in {symbol}, or fit")
        known[key] = value
    return Wishes(
        kinds=wished_kinds(order.laws),
        free=tuple(order.free),
        fixed=tuple(order.fixed),
        machine=Machine(**known),
        fitted=tuple(fitted),
        weight=cast(Weight, order.weight),
    )
