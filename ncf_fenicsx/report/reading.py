"""What a results folder holds, read back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np


def read_history(path: Path) -> Any:
    """Columns of a ``history.csv`` by name, each a vector."""
    return np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))


def read_record(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a results folder."""
    return dict(json.loads((folder / "run.json").read_text(encoding="utf-8")))


def read_snapshots(folder: Path) -> list[tuple[float, str]]:
    """Times in s and names of the field files of a results folder."""
    entries = ElementTree.parse(folder / "fields.pvd").getroot().iter("DataSet")
    return [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in entries]
