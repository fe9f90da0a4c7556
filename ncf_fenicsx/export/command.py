"""``ncf-fenicsx export``: a results folder as files of another program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.export.decks import abaqus_files, calculix_files
from ncf_fenicsx.export.deformed import Deformed
from ncf_fenicsx.export.lcmsim import lcmsim_files
from ncf_fenicsx.export.tables import csv_files
from ncf_fenicsx.export.vtkhdf import vtkhdf_files
from ncf_fenicsx.output.safe_files import replace, told
from ncf_fenicsx.parameters.units import parse_quantity
from ncf_fenicsx.report.reading import Results

FORMATS = {
    "abaqus": abaqus_files,
    "calculix": calculix_files,
    "vtkhdf": vtkhdf_files,
    "lcmsim": lcmsim_files,
    "csv": csv_files,
}
"""What makes the files of each format, by name; nothing is written before all are made."""


@dataclass(frozen=True)
class Order:
    """What the command line asks for, as texts.

    Attributes:
        folder: of the results.
        to: name of the format.
        out: folder for the files; ``export`` in that of the results unless given.
        time: of the step; the last one unless given.
    """

    folder: Path
    to: str
    out: Path | None
    time: str | None


def carry_out(order: Order) -> str:
    """Write the files; words on them.

    Raises:
        SceneError: something asked for is wrong, or the results lack what the format needs; nothing is written then.
        ResultError: a file cannot be written.
    """
    if order.to not in FORMATS:
        raise SceneError(f"--to {order.to}: expected {', '.join(FORMATS)}")
    time = None if order.time is None else parse_quantity(order.time, "s")
    if order.time is not None and time is None:
        raise SceneError(f"--time {order.time}: expected a time with its unit, such as '30 s'")
    out = order.out or order.folder / "export"
    if out.exists() and not out.is_dir():
        raise SceneError(f"--out {out}: is a file; expected a folder")
    deformed = Deformed.read(Results.read(order.folder), time)
    files = FORMATS[order.to](deformed)
    with told(out):
        out.mkdir(parents=True, exist_ok=True)
    for name, write in files.items():
        replace(out / name, write)
    return f"state at {deformed.time:.6g} s in {', '.join(str(out / name) for name in files)}"
