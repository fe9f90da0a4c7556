"""The wheel and the source archive build, hold what they must, and the wheel runs away from the checkout."""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from program import ROOT

from ncf_fenicsx.version import VERSION

pytestmark = pytest.mark.serial

BESIDE_PYTHON = {".toml", ".js", ".css", ".html", ".typed"}
"""Files of the package that are no modules."""
BUILD = "from setuptools import build_meta; print(build_meta.build_{kind}({folder!r}))"


def build(kind, source, folder):
    """Build a wheel or an sdist of a source tree; no network."""
    words = [sys.executable, "-c", BUILD.format(kind=kind, folder=str(folder))]
    ended = subprocess.run(words, cwd=source, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr[-2000:]
    return folder / ended.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def sdist(tmp_path_factory):
    """Source archive of the files that the checkout has, in a place that can be written to."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("sdist")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        (source / name).write_bytes((ROOT / name).read_bytes())
    for path in package_files():
        copy = source / path
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes((ROOT / path).read_bytes())
    return build("sdist", source, out)


@pytest.fixture(scope="module")
def wheel(sdist, tmp_path_factory):
    """Wheel from that archive, as pip would build it."""
    folder, out = tmp_path_factory.mktemp("unpacked"), tmp_path_factory.mktemp("wheel")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    return build("wheel", next(folder.iterdir()), out)


def package_files():
    """Files of the package, without those that only make the viewer's libraries anew."""
    found = [path.relative_to(ROOT) for path in (ROOT / "ncf_fenicsx").rglob("*") if path.is_file()]
    kept = (path for path in found if path.suffix in BESIDE_PYTHON | {".py"})
    return sorted(path for path in kept if not {"vendor", "node_modules", "__pycache__"} & set(path.parts))


def test_the_source_archive_has_all_of_the_package(sdist):
    with tarfile.open(sdist) as archive:
        names = {Path(*Path(name).parts[1:]) for name in archive.getnames()}
    assert {*package_files(), Path("pyproject.toml"), Path("README.md"), Path("LICENSE")} <= names


def test_the_wheel_has_all_of_the_package_and_its_licence(wheel):
    assert wheel.name == f"ncf_fenicsx-{VERSION}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = [Path(name) for name in archive.namelist()]
    assert sorted(path for path in names if path.parts[0] == "ncf_fenicsx") == package_files()
    assert "LICENSE" in {path.name for path in names if path.parts[0] != "ncf_fenicsx"}
    assert Path("ncf_fenicsx/py.typed") in names


def test_the_wheel_runs_away_from_the_checkout(wheel, tmp_path):
    place = tmp_path / "site"
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", str(place)]
    subprocess.run([*install, str(wheel)], check=True, capture_output=True)
    environment = os.environ | {"PYTHONPATH": str(place)}
    where = [sys.executable, "-c", "import ncf_fenicsx; print(ncf_fenicsx.__file__)"]
    for words, expected in ((where, str(place)), ([sys.executable, place / "bin/ncf-fenicsx", "fabrics"], "saertex")):
        ended = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stderr[-2000:]
        assert expected in ended.stdout


def test_the_conda_recipe_asks_for_what_the_package_needs():
    jinja2, yaml = pytest.importorskip("jinja2"), pytest.importorskip("yaml")
    recipe = ROOT / "docker" / "conda"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]

    class Found:
        def group(self, number):
            return (VERSION, VERSION)[number]

    text = jinja2.Template((recipe / "meta.yaml").read_text("utf-8")).render(
        load_file_data=lambda path, **_: tomllib.loads((recipe / path).read_text("utf-8")),
        load_file_regex=lambda *_, **__: Found(),
    )
    made = yaml.safe_load(text)
    names = {requirement.split()[0] for requirement in made["requirements"]["run"]}
    assert len(names) == len(project["dependencies"]) + 2  # and python, petsc
    assert "fenics-dolfinx >=0.9,<0.12,!=0.10.*" in made["requirements"]["run"]
    assert made["package"]["version"] == VERSION
    assert made["build"]["entry_points"] == ["ncf-fenicsx = ncf_fenicsx.cli:main"]


def test_the_citation_can_be_read():
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["license"] == "MIT"
