"""Stack of layers with a band refined under the roller, in hexahedra: ``python3 meshes/stack.py stack.msh``.

Physical volumes ``layer_1`` (bottom) to ``layer_N``, physical surfaces ``bottom``, ``top``, ``x_min``, ``x_max``,
``y_min``, ``y_max``. Lengths are in metres. All numbers are options: see ``--help``.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

import gmsh

from ncf_fenicsx.parameters.units import parse_number

SIDES = ("y_min", "x_max", "y_max", "x_min")


def build_stack(
    size: tuple[float, float],
    band: float,
    divisions: tuple[int, int, int],
    layers: int,
    thickness: float,
    through: int,
    growth: float = 1.0,
) -> None:
    """Mesh a stack in the current gmsh model.

    Args:
        size: extent in x and y in m.
        band: extent in x, from 0, of the refined band in m.
        divisions: elements along x in the band, along x beside it, and along y.
        layers: number of layers.
        thickness: of each layer in m.
        through: elements through each layer.
        growth: ratio of neighbouring element sizes beside the band.
    """
    geo = gmsh.model.geo
    groups: dict[str, list[int]] = defaultdict(list)
    low, high = ([geo.addPoint(x, y, 0.0) for x in (0.0, band, size[0])] for y in (0.0, size[1]))
    across = [geo.addLine(low[i], high[i]) for i in range(3)]
    faces = []
    for i in range(2):
        front, back = geo.addLine(low[i], low[i + 1]), geo.addLine(high[i], high[i + 1])
        for line in (front, back):
            geo.mesh.setTransfiniteCurve(line, divisions[i] + 1, "Progression", growth if i else 1.0)
        loop = geo.addCurveLoop([front, across[i + 1], -back, -across[i]])
        faces.append(geo.addPlaneSurface([loop]))
    for line in across:
        geo.mesh.setTransfiniteCurve(line, divisions[2] + 1)
    for face in faces:
        geo.mesh.setTransfiniteSurface(face)
        geo.mesh.setRecombine(2, face)
    groups["bottom"] = list(faces)
    for layer in range(layers):
        faces = _extrude(faces, layer, thickness, through, groups)
    groups["top"] = faces
    geo.synchronize()
    for name, entities in groups.items():
        gmsh.model.addPhysicalGroup(3 if name.startswith("layer") else 2, entities, name=name)
    gmsh.model.mesh.generate(3)


def _extrude(faces: list[int], layer: int, thickness: float, through: int, groups: dict[str, list[int]]) -> list[int]:
    """Extrude both faces by one layer, name what comes of it, return the faces on top."""
    tops = []
    for position, face in enumerate(faces):
        made = gmsh.model.geo.extrude([(2, face)], 0, 0, thickness, numElements=[through], recombine=True)
        tops.append(made[0][1])
        groups[f"layer_{layer + 1}"].append(made[1][1])
        inner = "x_max" if position == 0 else "x_min"
        for name, (_, side) in zip(SIDES, made[2:], strict=True):
            if name != inner:
                groups[name].append(side)
    return tops


def positive(text: str) -> float:
    """Number of an option, read as the numbers of a scene: Python's own reading takes 1_2 for 12."""
    value = parse_number(text)
    if value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a positive number with a decimal point, such as 0.002")
    return value


def count(text: str) -> int:
    """Whole number of an option, 1 or more."""
    if not (text.isascii() and text.isdigit() and int(text)):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number of 1 or more")
    return int(text)


def options() -> argparse.ArgumentParser:
    """Command line of the mesh scripts; the defaults are the paper's quarter stack."""
    parser = argparse.ArgumentParser(formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("file", type=Path, help="gmsh file to write")
    parser.add_argument("--size", type=positive, nargs=2, default=(0.076, 0.076), help="extent in x and y (m)")
    parser.add_argument("--band", type=positive, default=0.006, help="extent in x of the refined band (m)")
    parser.add_argument(
        "--divisions", type=count, nargs=3, default=(16, 20, 24), help="in the band, beside it, along y"
    )
    parser.add_argument("--layers", type=count, default=4, help="number of layers")
    parser.add_argument("--thickness", type=positive, default=0.002, help="thickness of a layer (m)")
    parser.add_argument("--through", type=count, default=1, help="elements through a layer")
    parser.add_argument("--growth", type=positive, default=1.12, help="ratio of neighbouring elements beside the band")
    return parser


def build_from(given: argparse.Namespace) -> None:
    """Start gmsh and mesh the stack that the command line asks for."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    size, divisions = tuple(given.size), tuple(given.divisions)
    build_stack(size, given.band, divisions, given.layers, given.thickness, given.through, given.growth)


def write_mesh(file: Path) -> None:
    """Write the current gmsh model, only what has a physical name."""
    gmsh.write(str(file))
    gmsh.finalize()


if __name__ == "__main__":
    given = options().parse_args()
    build_from(given)
    write_mesh(given.file)
