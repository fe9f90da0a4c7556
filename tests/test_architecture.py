"""Folders import only from folders before them in the row; PETSc stays in one; each table of laws is one file."""

import ast
import importlib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import ncf_fenicsx
from ncf_fenicsx.parameters.kinds import kinds
from ncf_fenicsx.scene.laws import Laws

pytestmark = pytest.mark.serial

PACKAGE = Path(ncf_fenicsx.__file__).parent
ROW = (
    ("parameters", "errors", "grid_lines", "terminal", "version"),
    ("laws",),
    ("tools",),
    ("scene",),
    ("mesh",),
    ("contact",),
    ("mechanics",),
    ("solver", "output"),
    ("report",),
    ("simulation", "export", "workers"),
    ("study", "calibration", "accuracy", "sweeps"),
    ("cli",),
)
"""Folders, and the files beside them, in the order of the data's flow; neighbours in a row do not know each other."""
PLACE = {name: place for place, names in enumerate(ROW) for name in names}
MESH_FREE = {"parameters", "errors", "version", "laws", "tools", "scene", "report", "export"}
"""Folders that know neither DOLFINx nor PETSc nor MPI."""


def files(folder=PACKAGE):
    return sorted(path for path in folder.rglob("*.py") if path.name not in ("__init__.py", "__main__.py"))


def name_of(path):
    return path.relative_to(PACKAGE).as_posix()


def imported(path):
    """Full names of what a file imports."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{name.name}" for name in node.names)


def neighbours(path, folder):
    """Files of its own folder that a file imports from."""
    inside = f"ncf_fenicsx.{folder.name}."
    names = {name.removeprefix(inside).split(".")[0] for name in imported(path) if name.startswith(inside)}
    return {name for name in names if (folder / f"{name}.py").exists()}


def folders():
    return sorted(path.parent for path in PACKAGE.glob("*/__init__.py"))


def test_every_folder_has_its_place():
    assert {path.relative_to(PACKAGE).parts[0].removesuffix(".py") for path in files()} == set(PLACE)


@pytest.mark.parametrize("path", files(), ids=name_of)
def test_imports_go_along_the_row(path):
    here = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    for name in imported(path):
        package, *rest = name.split(".")
        if package == "ncf_fenicsx":
            assert rest
            assert rest[0] == here or PLACE[rest[0]] < PLACE[here], f"{name_of(path)} imports {name}"


@pytest.mark.parametrize("path", files(), ids=name_of)
def test_dolfinx_and_petsc_stay_in_their_folders(path):
    here = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    libraries = {name.split(".")[0] for name in imported(path)}
    if here in MESH_FREE:
        assert not libraries & {"dolfinx", "petsc4py", "slepc4py", "mpi4py"}
    if here != "solver":
        assert not libraries & {"petsc4py", "slepc4py"}


@pytest.mark.parametrize("folder", folders(), ids=lambda folder: folder.name)
def test_files_of_a_folder_import_each_other_in_no_circle(folder):
    graph = {path.stem: neighbours(path, folder) for path in folder.glob("[a-z]*.py")}
    assert list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the circle


def test_each_table_of_laws_is_a_file_with_its_base_class_and_its_kinds():
    tables = [name for name in Laws.model_fields if name != "volume_fraction"]  # a word, no table
    for family in [*tables, "permeability", "contact"]:
        found = {part.__module__ for part in kinds(family).values() if part.__module__.startswith("ncf_fenicsx.")}
        assert found == {f"ncf_fenicsx.laws.{family}"}


@pytest.mark.parametrize("folder", ["laws", "tools"])
def test_a_folder_of_kinds_names_all_of_its_files(folder):
    """No scan: a reader and an editor find each kind by its import."""
    package = importlib.import_module(f"ncf_fenicsx.{folder}")
    found = {path.stem for path in files(PACKAGE / folder)}
    assert {name for name in found if hasattr(package, name)} == found


def test_files_of_tests_stay_readable():
    lines = {path.name: path.read_text("utf-8").count("\n") for path in Path(__file__).parent.rglob("*.py")}
    assert {name: count for name, count in lines.items() if count > 300} == {}


@pytest.mark.parametrize("path", files(), ids=name_of)
def test_files_and_functions_stay_readable(path):
    text = path.read_text("utf-8")
    assert text.count("\n") <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno - node.lineno < 45, f"{name_of(path)}: {node.name}"
