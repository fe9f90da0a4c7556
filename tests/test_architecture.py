"""Rooms import only from rooms before them; a new law or tool is one file."""

import ast
from pathlib import Path

import pytest

import ncf_fenicsx
from ncf_fenicsx.parts import families, kinds

PACKAGE = Path(ncf_fenicsx.__file__).parent
ORDER = (
    ("units", "scene_errors", "parallel", "timing", "machine", "files", "state_parts", "interruption"),
    ("parts",),
    ("motion", "kinematics"),
    ("contact",),
    ("contracts",),
    ("laws", "tools"),
    ("scene_laws", "scene_stack", "scene_run"),
    ("scene",),
    ("history_file", "hexahedra", "compat", "material", "mirror", "surface_lines"),
    ("elements",),
    ("plan_elements",),
    ("mortar", "placement", "gmsh_file", "states", "symbols", "fabric", "faces", "surfaces"),
    ("mesh", "body", "memory"),
    ("pairing", "grip", "catch", "supports", "defects", "viscosity", "recovery"),
    ("rigid_contact",),
    ("coupling_blocks", "force_control"),
    ("interface",),
    ("contacts",),
    ("problem",),
    ("solver", "stepping", "steadying", "contact_measures", "energies", "stable_step"),
    ("measures", "sections", "checkpoint", "run_record", "step_solver", "central_differences"),
    ("outputs", "progress", "report", "reference", "preview", "settling", "curves"),
    ("loss_of_stability", "comparison", "opening"),
    ("simulation", "explicit", "benchmark"),
    ("run_benchmark",),
    ("study",),
    ("cli",),
)
"""Rooms in the order of the data's flow; neighbours in a row do not know each other."""
RANK = {room: rank for rank, rooms in enumerate(ORDER) for room in rooms}
PURE = {
    "scene",
    "scene_laws",
    "scene_stack",
    "scene_run",
    "stepping",
    "motion",
    "kinematics",
    "contracts",
    "parts",
    "units",
    "laws",
    "tools",
    "material",
    "fabric",
    "contact",
    "hexahedra",
    "mortar",
    "mirror",
    "surfaces",
    "surface_lines",
}


def files():
    return [path for path in PACKAGE.rglob("*.py") if path.name != "__init__.py" and path.name != "__main__.py"]


def room_of(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{name.name}" for name in node.names)


@pytest.mark.parametrize("path", files(), ids=lambda path: path.stem)
def test_no_room_imports_against_the_flow(path):
    room = room_of(path)
    for name in imported(path):
        parts = name.split(".")
        if parts[0] == "ncf_fenicsx" and len(parts) > 1 and parts[1] in RANK:
            assert RANK[parts[1]] < RANK[room] or parts[1] == room, f"{room} imports {parts[1]}"


@pytest.mark.parametrize("path", files(), ids=lambda path: path.stem)
def test_dolfinx_and_petsc_stay_in_their_rooms(path):
    names = {name.split(".")[0] for name in imported(path)}
    if room_of(path) in PURE:
        assert not names & {"dolfinx", "petsc4py", "mpi4py"}
    if "petsc4py" in names:
        assert room_of(path) == "solver"


def test_every_file_of_a_law_or_tool_brings_one():
    for room in ("laws", "tools"):
        modules = {part.__module__ for family in families() for part in kinds(family).values()}
        for path in (PACKAGE / room).glob("[a-z]*.py"):  # a leading underscore marks what several share
            assert f"ncf_fenicsx.{room}.{path.stem}" in modules
