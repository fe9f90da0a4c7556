"""The companion of a run: what it is, what error it tells, that it goes on, what it refuses."""

import json

import numpy as np
import pytest
from mpi4py import MPI
from program import DEMOS, call

from ncf_fenicsx import Scene, SceneError, run, simulation
from ncf_fenicsx.accuracy.companion import companion_of
from ncf_fenicsx.accuracy.sequence import plan
from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.two_ranks

STRIP = [
    "stack.layers=2",
    "stack.size=['12 mm', '1 mm']",
    "stack.divisions=[16, 1]",
    "stack.grading=[0, 0]",
    "stack.sides={y_min='symmetry', y_max='symmetry'}",
    "laws.shear.modulus=2 MPa",
    "tool.path.0.travel=['0 mm', '0 mm', '-0.2 mm']",
]
ASKED = "output.companion=true"


def scene_with(*changes):
    return Scene.read(DEMOS / "long_roller.toml", [*STRIP, *changes])


def record_in(folder):
    return json.loads((folder / "run.json").read_text("utf-8"))


@pytest.mark.serial
def test_it_has_half_the_mesh_and_half_the_steps_and_is_the_same_otherwise():
    scene = scene_with(ASKED)
    companion = companion_of(scene)
    assert companion.stack.divisions == (8, 1)
    assert companion.solver.step_refinement == scene.solver.step_refinement / 2
    assert companion.tool == scene.tool
    assert companion.interface == scene.interface
    assert not companion.output.companion
    assert plan(scene)[0].startswith("companion: 8 x 1 elements a layer, steps x 2: about ")
    assert plan(scene_with()) == []
    free = scene_with(ASKED, "stack.sides={y_min='symmetry', y_max='free'}")
    assert companion_of(free).stack.divisions == (8, 1)


def test_the_true_error_of_the_force_is_inside_its_bar_at_every_step(folder, capsys):
    """The reference has a quarter of the element's length and of the step's size."""
    result = run(scene_with(ASKED), folder / "run")
    assert result.done, result.reason
    finer = scene_with("stack.divisions=[64, 1]", "solver.step_refinement=4", "output.picture=false")
    assert simulation.run(finer, folder / "finer").done
    if MPI.COMM_WORLD.rank:
        return
    found, reference = Results.read(folder / "run"), Results.read(folder / "finer").history
    force = found.history["tool_force"]
    true = np.abs(force - np.interp(found.history["time"], reference["time"], reference["tool_force"]))
    error = found.errors["tool_force_error"]
    loaded = force > 0.2 * force.max()
    assert (true[loaded] <= error[loaded]).all()
    assert np.median(error[loaded] / true[loaded]) < 10
    known = record_in(folder / "run")["accuracy"]
    assert known["quantities"]["force"]["value"] == force.max()
    assert known["companion"]["unknowns"] < 0.6 * record_in(folder / "run")["unknowns"]
    words = known["quantities"]["force"]["bar_words"]
    assert f"largest force: {force.max():.5g} N {words}" in capsys.readouterr().out
    assert words.split(",")[0] in (folder / "run" / "report.html").read_text("utf-8")


def test_it_goes_on_where_it_was_stopped_and_is_taken_away_with_its_run(folder):
    quiet = ["output.picture=false", "output.report=false"]
    scene = scene_with(ASKED, *quiet)
    own, companion = folder / "run", folder / "run" / "companion"
    assert simulation.run(scene, own).done
    on_root(MPI.COMM_WORLD, companion.mkdir)
    late = companion_of(scene)
    late = late.model_copy(update={"solver": late.solver.model_copy(update={"max_steps": 4})})
    assert not simulation.run(late, companion, overwrite=True).done
    before = on_root(MPI.COMM_WORLD, lambda: Results.read(companion).history["wall_time"])
    assert run(scene, own, restart=True).done
    assert "quantities" in on_root(MPI.COMM_WORLD, lambda: record_in(own)["accuracy"])
    after = on_root(MPI.COMM_WORLD, lambda: Results.read(companion).history["wall_time"])
    assert len(after) > len(before) == 5
    assert (after[:5] == before).all()  # not run again
    assert run(scene_with(*quiet), own, overwrite=True).done
    assert not companion.exists()
    assert "accuracy" not in on_root(MPI.COMM_WORLD, lambda: record_in(own))


@pytest.mark.serial
@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            ["stack.divisions=[1, 1]"],
            "output.companion: stack.divisions = \\[1, 1\\]: expected two elements or more along x or y",
        ),
        (
            ["stack.divisions=automatic"],
            'output.companion: stack.divisions = "automatic": expected numbers of elements',
        ),
        (["accuracy.tolerance=5 %"], r"output.companion = true: expected false with \[accuracy\]"),
    ],
)
def test_what_has_no_companion_is_refused_and_nothing_is_written(changes, expected, tmp_path):
    with pytest.raises(SceneError, match=expected):
        run(scene_with(ASKED, *changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.serial
def test_the_command_line_asks_for_one(tmp_path):
    words = [word for change in STRIP for word in ("--set", change)]
    ended = call("check", DEMOS / "long_roller.toml", *words, "--set", ASKED)
    assert "companion: 8 x 1 elements a layer" in ended.stdout
    refused = call("run", DEMOS / "long_roller.toml", "--companion", "--accuracy", "5 %", "--out", tmp_path / "out")
    assert refused.returncode == 2
    assert refused.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
