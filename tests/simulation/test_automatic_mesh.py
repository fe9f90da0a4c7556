"""Meshes that follow the solution: of a coarse run, written down, and better than even ones."""

import tempfile

import numpy as np
import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.reference_solution import VfField
from ncf_fenicsx.simulation import preview
from ncf_fenicsx.simulation.automatic_mesh import CoarseRun, CoarseRunEndedError, with_mesh_in_advance
from ncf_fenicsx.simulation.interruption import INTERRUPTED
from ncf_fenicsx.simulation.run_record import Result

pytestmark = pytest.mark.two_ranks

COMM = MPI.COMM_WORLD
MOVING = [
    {"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"},
    {"travel": ["4 mm", "0 mm", "0 mm"], "speed": "20 mm/min", "roll": True},
]


def scene_of(table, **stack):
    return Scene.from_table(table | {"stack": {k: v for k, v in (table["stack"] | stack).items() if v is not None}})


def automatic(table, error):
    return scene_of(table, divisions="automatic", mesh_error=error, grading=None)


def solved(scene, folder):
    """Its last row, and its field of Vf."""
    history = run(scene, folder).history
    COMM.barrier()
    return history[-1], VfField(folder)


def test_the_mesh_is_that_of_a_coarse_run_and_is_written_down(table, folder, monkeypatch):
    last, _ = solved(automatic(table, 0.03), folder / "first")
    found = Scene.read(folder / "first" / "scene.toml")
    x, y = (np.array(positions) for positions in found.stack.nodes)
    assert len(y) == 2, "nothing varies along y"
    assert 0.5 < last["vf_error_in_plane"] / 0.03 < 1.5
    assert np.diff(x).min() == np.diff(x)[x[:-1] < 2.5e-3].min(), "finest under the roller"
    assert (folder / "first" / "coarse_run" / "run.json").is_file()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    assert with_mesh_in_advance(automatic(table, 0.03), COMM).stack.nodes == found.stack.nodes
    COMM.barrier()
    assert {path.name for path in folder.iterdir()} == {"first"}, "of the coarse run nothing is left"
    again, _ = solved(found, folder / "second")
    assert again["tool_force"] == pytest.approx(last["tool_force"], rel=1e-9)
    assert run(found, folder / "first", restart=True).history[-1]["tool_force"] == last["tool_force"]


def test_a_coarse_run_that_is_ended_ends_the_run_and_tells_no_mesh(table, folder, monkeypatch):
    monkeypatch.setattr(CoarseRun, "run", lambda _: Result(False, f"{INTERRUPTED} by SIGTERM", folder, []))
    result = run(automatic(table, 0.03), folder / "ended")
    assert (result.done, result.reason) == (False, f"coarse run for the mesh: {INTERRUPTED} by SIGTERM")
    with pytest.raises(CoarseRunEndedError, match="SIGTERM"):
        with_mesh_in_advance(automatic(table, 0.03), COMM)


@pytest.mark.serial
def test_it_has_a_smaller_error_than_an_even_mesh_with_as_many_elements(table, folder):
    """A roller that travels, against four times as many elements; the whole of its path is seen, not its end."""
    strip = {"size": ["24 mm", "1 mm"], "sides": {"y_max": "symmetry"}}
    table = table | {"stack": table["stack"] | strip}
    table["tool"] = table["tool"] | {"position": ["4 mm", "0 mm"], "path": MOVING}
    row, field = solved(automatic(table, 0.08), folder / "automatic")
    x = np.array(Scene.read(folder / "automatic" / "scene.toml").stack.nodes[0])
    count = len(x) - 1
    even_row, even = solved(scene_of(table, divisions=[count, 1]), folder / "even")
    reference_row, reference = solved(scene_of(table, divisions=[4 * count, 1]), folder / "reference")
    rest = automatic(table, 0.08).stack.initial_volume_fraction
    assert field.off(reference, rest) < 0.8 * even.off(reference, rest)
    force = reference_row["tool_force"]
    assert abs(row["tool_force"] - force) < abs(even_row["tool_force"] - force)
    lengths = np.diff(x)
    on_path = (x[:-1] > 4e-3) & (x[1:] < 8e-3)
    assert lengths[on_path].max() < lengths[~on_path].max()


def test_elements_of_a_mesh_that_was_found_are_told(table):
    nodes = [["0 mm", "1 mm", "3 mm", "6 mm"], ["0 mm", "2 mm", "4 mm"]]
    scene = scene_of(table, nodes=nodes, size=["6 mm", "4 mm"], divisions=None, grading=None)
    lines = preview.preview(scene).splitlines()
    assert lines[0] == "elements of each layer: 3 along x, 1 to 3 mm long; 2 along y, 2 mm long"


def test_what_needs_numbers_says_so(table):
    scene = automatic(table, 0.03)
    with pytest.raises(SceneError, match=r'stack\.divisions = "automatic": a run finds them; expected two numbers'):
        _ = scene.stack.divisions_by_layer
    with pytest.raises(SceneError, match=r"expected two numbers with laws\.solid"):
        automatic(table | {"laws": {"solid": {"modulus": "1 MPa"}}}, 0.03)
