"""The program as it is called: commands, exit codes, demos."""

import json
import re
import subprocess
import sys

import pytest
from program import DEMOS, ENVIRONMENT, ROOT, call

import ncf_fenicsx
from ncf_fenicsx.output.measures import COLUMNS
from ncf_fenicsx.scene.keys import keys

pytestmark = pytest.mark.serial
SMALL = [
    "--set",
    "stack.layers=2",
    "--set",
    "stack.divisions=[6, 3]",
    "--set",
    "output.picture=false",
    "--set",
    "output.report=false",
]


def test_version_and_help():
    assert call("--version").stdout.strip() == ncf_fenicsx.__version__
    assert "SCENE.toml" in call("run", "--help").stdout


def test_check_shows_the_scene_in_si_and_what_will_be_built():
    ended = call("check", DEMOS / "roller.toml")
    assert ended.returncode == 0
    assert 'radius = "0.0025 m"' in ended.stdout
    assert "unknowns: 24600" in ended.stdout
    assert "2880 facing facets" in ended.stdout
    assert re.search(r"expected memory: 0\.\d+ GB", ended.stdout)


@pytest.mark.serial
@pytest.mark.parametrize("order", [1, 2])
def test_check_tells_the_unknowns_of_the_run(tmp_path, order):
    words = (DEMOS / "long_roller.toml", "--set", "stack.divisions=[6, 2]", "--set", f"stack.order={order}")
    checked = call("check", *words)
    call("run", *words, "--set", "solver.max_steps=1", "--out", tmp_path / "run")
    unknowns = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))["unknowns"]
    assert f"unknowns: {unknowns}\n" in checked.stdout


def test_a_run_that_ends_has_code_0_and_one_that_stops_code_1(tmp_path):
    scene = DEMOS / "roller.toml"
    done = call("run", scene, *SMALL, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "roller" / "history.csv").is_file()
    rows = (tmp_path / "results" / "roller" / "history.csv").read_text().splitlines()
    assert done.stdout.count("Vf max") == len(rows) - 1  # a line for each step
    stopped = call("run", scene, *SMALL, "--set", "solver.max_steps=2", "--out", tmp_path / "stopped", ranks=2)
    assert stopped.returncode == 1
    assert "max_steps = 2 reached" in stopped.stdout
    assert (tmp_path / "stopped" / "run.json").is_file()


def test_wrong_input_in_parallel_is_one_line_and_code_2(tmp_path):
    ended = call("run", "missing.toml", ranks=2, folder=tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.count("ncf-fenicsx: missing.toml") == 1
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("run", "--ranks", "0"), "run: .*--ranks.*0.*; expected what .* run --help tells"),
        (("run", "--rank", "2"), "run: .*--rank.*; expected what .* run --help tells"),
        (("runs",), ".*'runs'.*; expected what .* --help tells"),
        (("study", "stability", "--set"), ".*--set.*; expected what .*--help tells"),
        (("check",), "check: .*SCENE.toml.*; expected what .* check --help tells"),
    ],
)
def test_a_wrong_word_of_a_command_is_one_line_and_code_2(tmp_path, words, told):
    ended = call(*words, folder=tmp_path)
    assert ended.returncode == 2
    assert not ended.stdout
    assert re.fullmatch(f"ncf-fenicsx: {told}", ended.stderr.strip()), ended.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("run", "--ranks", "999"), "--ranks 999: expected at most [0-9]+ on this machine"),
        (("check", "--set", "=5"), "--set =5: expected KEY=VALUE"),
        (("check", "--set", "tool.path.1.speed=5 mm/s"), "--set tool.path.1.speed=5 mm/s: .*tool.path.0.speed"),
        (("study", "sensitivity", "--vary", "tool.radius=2 mm"), "--vary tool.radius=2 mm: does not vary"),
    ],
)
def test_a_wrong_value_of_an_option_is_one_line_and_code_2(tmp_path, words, told):
    ended = call(*words, DEMOS / "single_element.toml", folder=tmp_path)
    assert ended.returncode == 2
    assert re.match(f"ncf-fenicsx: {told}", ended.stderr), ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_no_word_at_all_is_the_help():
    ended = call()
    assert "calibrate" in ended.stdout + ended.stderr
    assert "expected what" not in ended.stdout + ended.stderr


ASCII = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}


@pytest.mark.parametrize("command", ["check", "run"])
def test_letters_that_the_locale_does_not_know_are_printed_all_the_same(tmp_path, command):
    text = 'title = "K\u00e4se"\n[tool]\nkind = "plate"\npath = [{hold = "1 s"}]\n[solver]\nmax_steps = 1\n'
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    words = [command, "case.toml", *SMALL]
    ended = call(*words, folder=tmp_path, environment=ASCII)
    assert ended.returncode == (command == "run"), ended.stderr
    assert "Traceback" not in ended.stderr
    assert command == "run" or 'title = "K\u00e4se"' in ended.stdout


def test_a_locale_that_cannot_read_an_argument_or_name_a_file_is_one_line(tmp_path):
    (tmp_path / "case.toml").write_text('duration = "1 s"\n[stack]\nmesh = "m\u00e4.msh"\n', encoding="utf-8")
    for words in (["check", "case.toml"], ["check", "k\u00e4se.toml"]):
        ended = call(*words, folder=tmp_path, environment=ASCII)
        assert ended.returncode == 2
        assert "expected LC_ALL=C.UTF-8 or PYTHONUTF8=1" in ended.stderr
        assert ended.stderr.count("\n") == 1


def test_a_rank_that_fails_ends_all_ranks(tmp_path):
    script = tmp_path / "one_fails.py"
    script.write_text(
        "from mpi4py import MPI\nimport ncf_fenicsx.cli as cli\nfrom ncf_fenicsx.simulation import simulation\n"
        "original = simulation.Simulation.accept\n"
        "def accept(self, progress, size, outcome):\n"
        "    if MPI.COMM_WORLD.rank == 1 and progress.steps == 2:\n        raise RuntimeError('rank 1 fails')\n"
        "    original(self, progress, size, outcome)\n"
        "simulation.Simulation.accept = accept\ncli.main()\n"
    )
    command = ["mpirun", "-n", "2", sys.executable, str(script), "run", str(DEMOS / "roller.toml"), *SMALL]
    ended = subprocess.run(
        [*command, "--out", str(tmp_path / "out")],
        env=ENVIRONMENT, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert ended.returncode != 0
    assert "rank 1 fails" in ended.stderr


def test_the_single_element_demo_agrees_with_its_closed_form(tmp_path):
    demo = DEMOS / "single_element.py"
    ended = subprocess.run(
        [sys.executable, str(demo), str(tmp_path)], env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    difference = float(re.search(r"closed form: (\S+)", ended.stdout).group(1))
    assert difference < 1e-8
    for figure in ("27.82", "41.95", "77.20"):
        assert figure in ended.stdout
    assert (tmp_path / "single_element.png").is_file()


def test_the_manual_has_a_table_of_all_columns_made_from_their_definition():
    manual = (ROOT / "docs" / "results.md").read_text("utf-8")
    assert "```{columns} ncf_fenicsx.output.measures" in manual
    assert all(unit and meaning for unit, meaning in COLUMNS.values())


def test_every_key_of_the_reference_stands_once():
    """What several kinds share is listed with them, not again for each."""
    names = [key for key, *_ in keys()]
    assert len(names) == len(set(names))
    assert {"tool.position", "tool(cylinder).edge", "interface(one_sided, stitched).penalty"} <= set(names)
    assert not any(name.endswith(").position") for name in names)
