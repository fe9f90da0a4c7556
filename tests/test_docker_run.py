"""What ``docker/run`` does before a command runs; a podman that only writes down its arguments stands in for podman."""

import os
import shutil
import subprocess
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parents[1]
STAND_IN = """#!/bin/sh
printf '%s\\n' "$@" >>"$RECORD"
case " $* " in
*" inspect "*/ncf-fenicsx:*) exit "${INSPECTED:-0}" ;;
*" build "*) echo "Error: no space left"; exit "${BUILT:-0}" ;;
*" run "*) cat; exit 7 ;;
esac
"""

pytestmark = pytest.mark.serial


class Checkout:
    """A checkout in a folder of its own, as far as ``docker/run`` needs one."""

    def __init__(self, folder, name="checkout"):
        self.root, self.home, self.bin, self.record = (folder / part for part in (name, "home", "bin", "record"))
        shutil.copytree(ROOT / "docker", self.root / "docker")
        for file in ("pyproject.toml", "README.md", "LICENSE", "ncf_fenicsx"):
            (self.root / file).symlink_to(ROOT / file)
        self.home.mkdir()
        self.bin.mkdir()
        self.stand_in("podman", STAND_IN)
        self.stand_in("docker", "#!/bin/sh\nexit 1\n")

    def stand_in(self, name, text):
        (self.bin / name).write_text(text)
        (self.bin / name).chmod(0o755)

    def run(self, *command, cwd=None, **changes):
        """Call ``docker/run``; a change of None takes a variable out of the environment."""
        changes = {"NCF_ENGINE": "podman", "HOME": str(self.home), "XDG_CACHE_HOME": None} | changes
        path = f"{self.bin}:{os.environ['PATH']}"
        environment = os.environ | {"PATH": path, "RECORD": str(self.record)} | changes
        self.record.unlink(missing_ok=True)
        ended = subprocess.run(
            [self.root / "docker" / "run", *command],
            cwd=cwd or self.root,
            env={name: value for name, value in environment.items() if value is not None},
            input="through the pipe",
            capture_output=True,
            text=True,
            check=False,
        )
        words = self.record.read_text().splitlines() if self.record.exists() else []
        seen = [words[place + 1].split(":")[-1] for place, word in enumerate(words) if word == "--volume"]
        return SimpleNamespace(code=ended.returncode, out=ended.stdout, err=ended.stderr, words=words, seen=seen)


@pytest.fixture
def checkout(tmp_path):
    return Checkout(tmp_path)


@pytest.fixture
def outside(tmp_path):
    """A folder that lies neither in the checkout nor in a folder that is always seen."""
    folder = tmp_path / "else where"
    folder.mkdir()
    return folder


def is_seen(path, call):
    return any(Path(path).is_relative_to(folder) for folder in call.seen)


def assert_refused(call, *parts):
    """One line that says why, before anything runs."""
    assert call.code == 1
    assert call.words == []
    assert call.err.startswith("docker/run: ")
    assert call.err.count("\n") == 1
    for part in parts:
        assert part in call.err


def test_exit_code_input_and_arguments_pass_through(checkout):
    call = checkout.run("ncf-fenicsx", "run", "a b", "", "*")
    assert (call.code, call.out) == (7, "through the pipe")
    assert call.words[-4:] == ["run", "a b", "", "*"]


@pytest.mark.parametrize("form", [["--out", "{}"], ["--out={}"], ["--set", 'stack.mesh="{}"'], ["{}"]])
@pytest.mark.parametrize("path", ["", "new/folder", "../else where/new"])
def test_a_path_outside_is_seen(checkout, outside, form, path):
    call = checkout.run("ncf-fenicsx", "run", *(word.format(outside / path) for word in form))
    assert call.code == 7
    assert is_seen(outside, call)
    assert call.seen.count(str(outside)) <= 1


def test_a_relative_path_outside_is_seen(checkout, outside):
    (outside / "scene.toml").touch()
    assert is_seen(outside, checkout.run("ncf-fenicsx", "run", "../else where/scene.toml"))


def test_both_ends_of_a_link_are_seen(checkout, outside):
    (checkout.root / "link").symlink_to(outside)
    assert is_seen(outside, checkout.run("ncf-fenicsx", "run", "demo.toml", "--out", "link/new"))
    beside = checkout.root.with_name("link")
    beside.symlink_to(outside)
    call = checkout.run("ncf-fenicsx", "run", "demo.toml", "--out", str(beside / "new"))
    assert is_seen(beside, call)
    assert is_seen(outside, call)


def test_results_are_seen_where_their_folder_is_a_link(checkout, outside):
    (checkout.root / "results").symlink_to(outside)
    assert is_seen(outside, checkout.run("ncf-fenicsx", "run", "demo.toml"))


def test_the_working_folder_is_seen_and_kept(checkout, outside):
    call = checkout.run("pytest", cwd=outside)
    assert is_seen(outside, call)
    assert call.words[call.words.index("--workdir") + 1] == str(outside)


def test_all_else_is_read_only(checkout):
    assert "--read-only" in checkout.run("pytest").words


@pytest.mark.parametrize("path", ["/", "/new_folder/x", "/usr/x", "/etc/x", "/dev/shm/x", "/proc/1", "/var/lib/new"])
@pytest.mark.parametrize("form", ["--out={}", "{}", "../../../../../../../../../..{}"])
def test_folders_of_the_system_are_refused(checkout, path, form):
    assert_refused(checkout.run("ncf-fenicsx", "run", form.format(path)), "of its own")


def test_the_working_folder_cannot_be_that_of_the_system(checkout):
    assert_refused(checkout.run("pytest", cwd="/"), "working folder /: ")
    assert_refused(checkout.run("pytest", cwd="/usr"), "working folder /usr: ")


@pytest.mark.parametrize(
    "words", [["bash", "-c", "/x/y --out=/z"], ["/usr/bin/env", "PATH=/bin:/x"], ["tee", "/dev/null"]]
)
def test_what_is_of_the_container_is_left_to_it(checkout, words):
    call = checkout.run(*words)
    assert call.code == 7
    assert call.seen == checkout.run("pytest").seen


def test_colons_are_named(tmp_path):
    folder = tmp_path / "a:b"
    folder.mkdir()
    checkout = Checkout(tmp_path)
    assert_refused(checkout.run("pytest", str(folder)), "colon", str(folder))
    assert_refused(checkout.run("pytest", cwd=folder), "colon", "working folder")
    assert_refused(checkout.run("pytest", XDG_CACHE_HOME=str(folder)), "colon", "XDG_CACHE_HOME")
    assert_refused(Checkout(folder).run("pytest"), "colon", "checkout")


def test_without_home(checkout, outside):
    assert checkout.run("pytest", HOME=None, XDG_CACHE_HOME=str(outside)).code == 7
    for empty in (None, ""):
        call = checkout.run("pytest", HOME=empty)  # the one from the list of users, where it can be written to
        if call.code != 7:
            assert_refused(call, "XDG_CACHE_HOME")


def test_a_home_that_cannot_be_written_to_is_named(checkout):
    assert_refused(checkout.run("pytest", HOME="/proc/none"), "XDG_CACHE_HOME")


def test_no_command_and_a_wrong_engine_are_named(checkout):
    assert_refused(checkout.run(), "expected a command")
    assert_refused(checkout.run("pytest", NCF_ENGINE="lxc"), "expected here, docker or podman")
    assert_refused(checkout.run("pytest", NCF_ENGINE="docker"), "daemon")


def test_docker_is_taken_where_it_answers(checkout):
    checkout.stand_in("docker", STAND_IN)
    call = checkout.run("pytest", NCF_ENGINE="docker")
    assert call.code == 7
    assert "--user" in call.words
    assert "--uidmap" not in call.words


def test_the_image_follows_what_it_is_made_from(checkout):
    def image():
        return checkout.run("pytest").words[-2]

    def change(file, old, new):
        text = (checkout.root / file).read_text()
        assert old in text
        (checkout.root / file).unlink()
        (checkout.root / file).write_text(text.replace(old, new))

    names = [image()]
    change("pyproject.toml", "line-length = 120", "line-length = 100")
    assert image() == names[0]
    for file, old, new in [
        ("pyproject.toml", '"rich"', '"rich>=13"'),
        ("docker/packages.txt", "openmpi-bin", "mpich      "),
        ("docker/image.sh", "chroot", "oci"),
    ]:
        change(file, old, new)
        names.append(image())
    assert len(set(names)) == 4


def test_another_dolfinx_is_another_image_of_another_debian(checkout):
    plain, first, later = (
        checkout.run(*words, "pytest", INSPECTED="1") for words in ([], ["--dolfinx", "0.9"], ["--dolfinx", "0.11"])
    )
    assert plain.words[-2:] == first.words[-2:]
    assert later.words[-1] == "pytest"
    assert later.words[-2] != first.words[-2]
    for call, version in ((first, "0.9"), (later, "0.11")):
        assert call.code == 7
        assert f"DOLFINX={version}" in call.words
    bases = [next(word for word in call.words if word.startswith("BASE=")) for call in (first, later)]
    assert len(set(bases)) == 2


def test_an_unknown_dolfinx_is_named(checkout):
    for words in (["--dolfinx", "0.10", "pytest"], ["--dolfinx"]):
        assert_refused(checkout.run(*words), "--dolfinx", "expected one of 0.9 0.11")


def test_a_missing_image_is_built_first(checkout):
    call = checkout.run("pytest", INSPECTED="1")
    assert call.code == 7
    assert call.words[call.words.index("--tag") + 1] == call.words[-2]
    assert call.words.index("build") < call.words.index("--read-only")
    assert call.words[call.words.index("--isolation") + 1] == "chroot"
    failed = checkout.run("pytest", INSPECTED="1", BUILT="1")
    assert failed.code == 1
    assert "the build failed: Error: no space left" in failed.err
    assert "--read-only" not in failed.words


def test_the_later_dolfinx_is_skipped_where_its_image_cannot_be_built(checkout):
    shutil.copytree(ROOT / ".ci", checkout.root / ".ci")
    path = f"{checkout.bin}:{os.environ['PATH']}"
    names = {"PATH": path, "RECORD": str(checkout.record), "HOME": str(checkout.home), "NCF_ENGINE": "podman"}
    words = [checkout.root / ".ci" / "later_dolfinx"]
    environment = os.environ | names | {"INSPECTED": "1", "BUILT": "1"}
    ended = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 0
    assert ended.stdout.startswith("skipped: DOLFINx 0.11 cannot be had here: docker/run: the build failed: ")
    not_starting = subprocess.run(words, env=os.environ | names, capture_output=True, text=True, check=False)
    assert not_starting.stdout.startswith("skipped: DOLFINx 0.11 cannot be had here: ")


def here(*command, **changes):
    """Call ``docker/run`` of this checkout in the present Python."""
    environment = os.environ | {"NCF_ENGINE": "here", "PYTHONPATH": ""} | changes
    present = ".".join(metadata.version("fenics-dolfinx").split(".")[:2])
    words = [ROOT / "docker" / "run", *([] if present == "0.9" else ["--dolfinx", present]), *command]
    return subprocess.run(words, env=environment, capture_output=True, text=True, check=False)


def test_the_present_python_runs_the_checkout():
    from ncf_fenicsx.version import VERSION

    assert here("bash", "-c", "command -v ncf-fenicsx").stdout.strip() == str(ROOT / "docker" / "bin" / "ncf-fenicsx")
    assert here("mpirun", "-n", "2", "ncf-fenicsx", "--version").stdout.split() == [VERSION] * 2
    assert here("bash", "-c", "exit 5").returncode == 5
    assert "no_such_tool is not installed here" in here("no_such_tool").stderr


@pytest.mark.parametrize(
    ("file", "text", "reason"),
    [
        ("fenics_dolfinx-0.10.0.dist-info/METADATA", "Name: fenics-dolfinx\nVersion: 0.10.0\n", "0.10.0 is here"),
        ("shapely/__init__.py", "raise ImportError('half of it')", "half of it"),
        ("slepc4py.py", "import os; os.abort()", ""),
        ("dolfinx.py", "", "dolfinx"),
    ],
    ids=["wrong version", "half installed", "aborts", "another module"],
)
def test_a_present_python_that_does_not_fit_is_not_taken(checkout, outside, file, text, reason):
    (outside / file).parent.mkdir(exist_ok=True)
    (outside / file).write_text(text)
    ended = here("true", PYTHONPATH=str(outside))
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1].startswith("docker/run: NCF_ENGINE=here: the present Python does not do: ")
    assert reason in ended.stderr
    assert checkout.run("true", NCF_ENGINE=None, PYTHONPATH=str(outside)).words[-1] == "true"  # podman has it
