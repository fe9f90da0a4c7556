"""VTK's HDF5 format (version 2.0, an unstructured grid), which ParaView reads from 5.11 on."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from ncf_fenicsx.export.deformed import Deformed
from ncf_fenicsx.export.files import Writer

HEXAHEDRON = 12
"""VTK's number of a hexahedron of eight nodes."""


def vtkhdf_files(deformed: Deformed) -> dict[str, Writer]:
    """``deformed.vtkhdf``: the deformed mesh, with the displacement and all fields."""
    nodes = {"displacement": deformed.displacement, **deformed.node_fields}
    cells = {"layer": deformed.layers.layer, **deformed.cell_fields}
    points, connectivity = deformed.points, deformed.cells

    def write(path: Path) -> None:
        with h5py.File(path, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = (2, 0)
            kind = np.array(b"UnstructuredGrid")
            root.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind.item())))
            root["NumberOfPoints"] = [len(points)]
            root["NumberOfCells"] = [len(connectivity)]
            root["NumberOfConnectivityIds"] = [connectivity.size]
            root["Points"] = points
            root["Connectivity"] = connectivity.ravel()
            root["Offsets"] = 8 * np.arange(len(connectivity) + 1)
            root["Types"] = np.full(len(connectivity), HEXAHEDRON, dtype=np.uint8)
            for group, fields in (("PointData", nodes), ("CellData", cells)):
                for name, values in fields.items():
                    root[f"{group}/{name}"] = values

    return {"deformed.vtkhdf": write}
