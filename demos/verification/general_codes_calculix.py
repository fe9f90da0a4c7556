"""The block of ``general_codes.py`` in CalculiX: ``python general_codes_calculix.py BLOCK.json`` prints a JSON line.

Needs ``ccx`` (Debian: ``apt-get install calculix-ccx``); nothing of ncf_fenicsx. The cylinder is a band of
hexahedra around its lowest line, all of whose nodes move as told.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from itertools import product
from math import cos, radians, sin
from pathlib import Path

ARC = 60.0
"""Degrees of the cylinder that are meshed, from the plane of symmetry (a little beyond it) on."""
FACETS = 240


def lattice(corners: tuple[int, int, int], first: int) -> tuple[list[list[int]], dict[tuple[int, int, int], int]]:
    """Hexahedra on a lattice of nodes, and the nodes' numbers."""
    nodes = {key: first + i for i, key in enumerate(product(*(range(n + 1) for n in corners)))}
    around = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    cells = product(*(range(n) for n in corners))
    return [[nodes[i + a, j + b, k + c] for a, b, c in around] for i, j, k in cells], nodes


def lines(rows: list) -> str:
    """Rows of numbers as lines of a deck."""
    return "\n".join(
        ", ".join(f"{value:.9g}" if isinstance(value, float) else str(value) for value in row) for row in rows
    )


def deck(block: dict) -> str:
    """Input of CalculiX, in mm and MPa."""
    (nx, ny, nz), (length, depth, height) = block["divisions"], block["size"]
    cells, nodes = lattice((nx, ny, nz), 1)
    places = [(n, length * i / nx, depth * j / ny, height * k / nz) for (i, j, k), n in nodes.items()]
    tool, tool_nodes = lattice((FACETS, 1, 1), len(nodes) + 1)
    radius, offset = block["radius"], 5.0
    for (i, j, k), n in tool_nodes.items():
        angle, r = radians(ARC * i / FACETS - offset), radius - 0.2 * radius * k
        places.append((n, r * sin(angle), -0.1 * depth + 1.2 * depth * j, height + radius - r * cos(angle)))
    top = [[n] for (_, _, k), n in nodes.items() if k == nz]
    sides = {"XSYM": 0, "YSYM": 1, "BOTTOM": 2}
    sets = "\n".join(
        f"*NSET, NSET={name}\n" + lines([[n] for key, n in nodes.items() if key[axis] == 0])
        for name, axis in sides.items()
    )
    return f"""*NODE, NSET=ALL
{lines(places)}
*ELEMENT, TYPE=C3D8, ELSET=BLOCK
{lines([[e, *cell] for e, cell in enumerate(cells, 1)])}
*ELEMENT, TYPE=C3D8, ELSET=CYLINDER
{lines([[e, *cell] for e, cell in enumerate(tool, len(cells) + 1)])}
{sets}
*NSET, NSET=TOP
{lines(top)}
*NSET, NSET=TOOL
{lines([[n] for n in tool_nodes.values()])}
*SURFACE, NAME=UPPER, TYPE=NODE
TOP
*SURFACE, NAME=LOWER, TYPE=ELEMENT
CYLINDER, S1
*MATERIAL, NAME=SOLID
*HYPERELASTIC, NEO HOOKE
{block["shear_modulus"] / 2!r}, {2 / block["bulk_modulus"]!r}
*SOLID SECTION, ELSET=BLOCK, MATERIAL=SOLID
*MATERIAL, NAME=STEEL
*ELASTIC
{block["modulus"]!r}, 0.
*SOLID SECTION, ELSET=CYLINDER, MATERIAL=STEEL
*SURFACE INTERACTION, NAME=PENALTY
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{block["penalty"]!r}
*CONTACT PAIR, INTERACTION=PENALTY, TYPE=NODE TO SURFACE
UPPER, LOWER
*BOUNDARY
XSYM, 1, 1
YSYM, 2, 2
BOTTOM, 3, 3
TOOL, 1, 2
*STEP, NLGEOM, INC=1000
*STATIC, DIRECT
{1 / block["steps"]!r}, 1.
*BOUNDARY
TOOL, 3, 3, {-block["travel"]!r}
*NODE PRINT, NSET=TOOL, TOTALS=ONLY
RF
*END STEP
"""


def press(block: dict) -> dict:
    """Press the cylinder into the block; force on it in N, and Newton iterations."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "block.inp").write_text(deck(block), encoding="utf-8")
        threads = {"OMP_NUM_THREADS": str(os.cpu_count())}
        run = subprocess.run(
            ["ccx", "block"], cwd=folder, env=os.environ | threads, capture_output=True, text=True, check=False
        )
        totals = re.findall(
            r"total force.*\n\s*\n\s*(\S+)\s+(\S+)\s+(\S+)", Path(folder, "block.dat").read_text("utf-8")
        )
        if "Job finished" not in run.stdout or len(totals) < block["steps"]:
            raise SystemExit("CalculiX did not finish: " + run.stdout[-600:])
    iterations = len(re.findall(r"^ iteration +\d+", run.stdout, re.MULTILINE))
    return {"force": abs(float(totals[-1][2])), "iterations": iterations}


if __name__ == "__main__":
    print(json.dumps(press(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))))
