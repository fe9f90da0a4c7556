"""``pyproject.toml`` names what the package needs; the image, the manual and the imports agree with it."""

import ast
import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
DEBIAN = {
    "fenics-dolfinx": "python3-dolfinx",
    "petsc4py": "python3-petsc4py-real",
    "slepc4py": "python3-slepc4py-real",
}
"""Debian's packages that are called neither python3-NAME nor NAME."""
BESIDE = {"python3-dev", "python3-pip", "python3-dolfinx-real"}
"""Packages that no dependency asks for: headers for compiled forms, what installs the rest, DOLFINx's real half."""
MODULES = {
    "fenics-dolfinx": {"dolfinx", "basix", "ufl"},
    "pydantic": {"pydantic", "pydantic_core"},
    "matplotlib": {"matplotlib", "mpl_toolkits"},
    "typer": {"typer", "click"},
}
"""What is imported from a dependency under other names than its own."""
CONDA = {"gmsh": "python-gmsh"}

pytestmark = pytest.mark.serial


def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def names(requirements):
    return {Requirement(text).name.lower() for text in requirements}


def needed():
    return names(project()["project"]["dependencies"])


def extra(*chosen):
    """Names of what extras ask for; of all of them unless some are chosen."""
    extras = project()["project"]["optional-dependencies"]
    return set().union(*(names(extras[name]) for name in chosen or extras))


def packages():
    """Rows of the table of Debian's packages: a name, and a version for each DOLFINx."""
    lines = (ROOT / "docker" / "packages.txt").read_text("utf-8").splitlines()
    return [line.split() for line in lines if line and not line.startswith("#")]


def by_debian():
    return {name for name, *_ in packages()[2:]}


def by_pip():
    """Names of the packages that the commands in the Dockerfile install by pip."""
    text = (ROOT / "docker" / "Dockerfile").read_text("utf-8").replace("\\\n", " ")
    words = shlex.split(" ".join(re.findall(r"pip install ([^&\n]*)", text)))
    return {word.split("==")[0] for word in words if not word.startswith(("-", "/"))}


def test_each_package_has_a_version_for_each_dolfinx():
    (first, *versions), (second, *releases), *rest = packages()
    assert (first, second) == ("dolfinx", "debian")
    assert {len(row) for row in packages()} == {1 + len(versions)} == {1 + len(releases)}
    assert len({name for name, *_ in rest}) == len(rest)
    wanted = next(Requirement(text) for text in project()["project"]["dependencies"] if "dolfinx" in text)
    packaged = next(row[1:] for row in rest if row[0] == "python3-dolfinx")
    for version, found in zip(versions, packaged, strict=True):
        assert wanted.specifier.contains(f"{version}.0")
        assert found.startswith(f"1:{version}.")


def test_the_image_has_every_dependency():
    debian, pip = by_debian(), by_pip()
    for name in needed() | extra():
        choices = {DEBIAN[name]} if name in DEBIAN else {f"python3-{name}", name}
        assert choices & debian or name in pip, f"{name}: expected one of {sorted(choices)} in docker/packages.txt"


def test_the_image_has_no_python_package_that_nothing_asks_for():
    asked = needed() | extra() | names(project()["build-system"]["requires"])
    allowed = {DEBIAN.get(name, f"python3-{name}") for name in asked} | BESIDE
    assert {name for name in by_debian() if name.startswith("python3-")} <= allowed
    assert by_pip() <= asked


def test_the_package_imports_what_it_depends_on_and_no_more():
    imported = set()
    for file in (ROOT / "ncf_fenicsx").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {name.name.split(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(node.module.split(".")[0])
    modules = {name: MODULES.get(name, {name.replace("-", "_")}) for name in needed()}
    assert imported - sys.stdlib_module_names - {"ncf_fenicsx"} <= set().union(*modules.values())
    assert [name for name, own in modules.items() if not own & imported] == []


def test_the_manual_names_all_for_conda():
    manual = (ROOT / "docs" / "installing.md").read_text("utf-8").replace("\\\n", " ")
    command = re.search(r"conda create -n ncf -c conda-forge (.*?)\n", manual)
    listed = {word.split("=")[0] for word in shlex.split(command[1])}
    assert listed == {CONDA.get(name, name) for name in needed() | extra("dev")}
