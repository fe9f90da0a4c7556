"""A run that goes on from its checkpoint repeats the history of one that never stopped."""

import meshio
import numpy as np
import pytest
from mpi4py import MPI
from runs_apart import compare

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.output.checkpoint import NAME
from ncf_fenicsx.simulation import restart
from ncf_fenicsx.simulation.simulation import Simulation

COMM = MPI.COMM_WORLD
DOWN = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}
UP = {"travel": ["0 mm", "0 mm", "0.2 mm"], "speed": "2 mm/min"}
ALONG = {"travel": ["1.5 mm", "0 mm", "0 mm"], "speed": "0.5 mm/s", "roll": True}
CASES = {
    "penalty and stitches": {},
    "multipliers": {"contact": {"kind": "augmented_lagrangian"}},
    "friction of a travelling roller": {"friction": {"coefficient": 0.2}},
    "nitsche": {"contact": {"kind": "nitsche"}},
}


def contact_case(name):
    ways = CASES[name]
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [[6, 2], [8, 3]], "grading": [0, 0]},
        "interface": {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0} | ways,
        "tool": {"width": "infinite", "path": [DOWN, ALONG, UP]} | ways,
        "laws": {"shear": {"modulus": "2 MPa"}, "rate": {"feed": "process"}},
    }


def law_case():
    relaxation = {"kind": "maxwell", "branches": [{"share": 0.3, "time": "5 s"}]}
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": {"kind": "plate", "path": [DOWN, {"hold": "20 s"}, UP]},
        "laws": {"unloading": {"kind": "permanent_set"}, "relaxation": relaxation},
    }


def force_case():
    pressed = {"hold": "10 s", "force": "0.1 N"}
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": {"width": "infinite", "path": [pressed, ALONG | {"force": "0.1 N"}]},
        "laws": {"shear": {"modulus": "2 MPa"}, "rate": {"feed": "process"}},
    }


KEPT = ("kept", "layers")
TABLES = {name: contact_case(name) for name in CASES} | {"memory of the laws": law_case(), "force": force_case()}
TABLES |= {f"{way} factors": contact_case("penalty and stitches") | {"solver": {"factors": way}} for way in KEPT}
TABLES["order 2"] = contact_case("nitsche")
TABLES["order 2"]["stack"] |= {"order": 2, "divisions": [[3, 1], [4, 2]]}


ON_THREE_RANKS = ("memory of the laws", "order 2")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in ON_THREE_RANKS else pytest.mark.two_ranks) for name in TABLES]
)
def test_a_run_that_goes_on_repeats_the_history_of_one_that_never_stopped(folder, name):
    table = TABLES[name] | {"output": {"picture": False, "report": False}}
    whole = run(Scene.from_table(table), folder / "whole")
    assert whole.done, whole.reason
    steps = len(whole.history) - 1
    assert steps > 8
    stops = (0, steps // 3, 2 * steps // 3) if COMM.size == 1 else (2 * steps // 3,)  # one tells ranks apart
    for stop in stops:
        solver = table.get("solver", {}) | {"max_steps": max(stop, 1)}
        scene = Scene.from_table(table | {"solver": solver})
        run(scene, folder / f"parts_{stop}", restart=stop > 0)
        parts = run(Scene.from_table(table), folder / f"parts_{stop}", restart=True)
        assert parts.done, parts.reason
        compare(parts.history, whole.history)
    if COMM.rank == 0:
        last = [meshio.read(sorted((folder / part).glob("fields/*.vtu"))[-1]) for part in ("whole", f"parts_{stop}")]
        assert [len(list((folder / part).glob("fields/*.vtu"))) for part in ("whole", f"parts_{stop}")] == [
            steps + 1
        ] * 2
        moved = [mesh.point_data["displacement"] for mesh in last]
        assert np.abs(moved[0] - moved[1]).max() < 1e-10 * np.abs(moved[0]).max()


def test_a_rank_without_a_cell_saves_and_goes_on(folder):
    table = law_case() | {"output": {"picture": False, "report": False}}
    table["stack"] = {"layers": 1, "size": ["4 mm", "4 mm"], "divisions": [1, 1]}
    whole = run(Scene.from_table(table), folder / "whole")
    run(Scene.from_table(table | {"solver": {"max_steps": 3}}), folder / "parts")
    parts = run(Scene.from_table(table), folder / "parts", restart=True)
    compare(parts.history, whole.history)


def files(folder):
    """Content of each file of a run, as rank 0 sees it."""
    found = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} if COMM.rank == 0 else None
    return COMM.bcast(found)


def test_a_restart_that_is_refused_writes_nothing_and_a_good_one_goes_on(folder):
    table = law_case() | {"output": {"picture": False, "report": False}, "solver": {"max_steps": 4}}
    run(Scene.from_table(table), folder / "run")
    before = files(folder / "run")
    other = table | {"stack": table["stack"] | {"divisions": [5, 2]}}
    for refused, key in ((other, r"stack\.divisions = \[5, 2\]"), (table | {"laws": {}}, r"laws\.relaxation = none")):
        with pytest.raises(SceneError, match=rf"{key}: a restart may change title, solver, output.*; expected"):
            run(Scene.from_table(refused), folder / "run", restart=True)
        assert files(folder / "run") == before
    assert run(Scene.from_table(table | {"solver": {}}), folder / "run", restart=True).done


def test_a_scene_that_was_edited_in_the_folder_is_no_other_scene_of_the_checkpoint(folder):
    """The checkpoint knows its own scene: laws leave no trace in its fields."""
    table = law_case() | {"output": {"picture": False, "report": False}, "solver": {"max_steps": 2}}
    run(Scene.from_table(table), folder / "run")
    if COMM.rank == 0:
        edited = (folder / "run" / "scene.toml").read_text().replace('gravity = "9.81', 'gravity = "1.62')
        (folder / "run" / "scene.toml").write_text(edited)
    COMM.barrier()
    before = files(folder / "run")
    with pytest.raises(SceneError, match=r"gravity = '1.62 m/s\^2'.*expected '9.81 m/s\^2'"):
        run(Scene.read(folder / "run" / "scene.toml"), folder / "run", restart=True)
    assert files(folder / "run") == before


def test_a_checkpoint_of_another_mesh_is_refused_before_anything_is_written(folder, monkeypatch):
    """A mesh file may have changed under its name, which no key tells."""
    table = law_case() | {"output": {"picture": False, "report": False}, "solver": {"max_steps": 2}}
    run(Scene.from_table(table), folder / "run")
    before = files(folder / "run")
    other = table | {"stack": table["stack"] | {"divisions": [5, 2]}}
    monkeypatch.setattr(restart, "check_changes", lambda *_: None)
    with pytest.raises(SceneError, match=r"rows of .*; expected"):
        run(Scene.from_table(other), folder / "run", restart=True)
    with pytest.raises(SceneError, match="fields are not those of the scene"):
        run(Scene.from_table(table | {"laws": {}}), folder / "run", restart=True)
    assert files(folder / "run") == before


@pytest.mark.two_ranks
def test_a_longer_path_goes_on_where_the_shorter_one_ended(folder):
    table = contact_case("penalty and stitches") | {"output": {"picture": False, "report": False}}
    steps = {"first_step": "1 s", "largest_step": "2 s"}
    longer = {"tool": table["tool"] | {"path": [DOWN, ALONG | {"travel": ["2 mm", "0 mm", "0 mm"]}, UP]}}
    shorter = {"tool": table["tool"] | {"path": [DOWN, ALONG]}}
    first = run(Scene.from_table(table | shorter | {"solver": steps}), folder / "run")
    assert first.done
    ended = run(Scene.from_table(table | longer | {"solver": steps}), folder / "run", restart=True)
    assert ended.done
    kept, before = (
        [{name: row[name] for name in set(row) - {"wall_time"}} for row in rows]  # each rank has a clock of its own
        for rows in (ended.history[: len(first.history)], first.history)
    )
    assert kept == before
    assert ended.history[-1]["time"] == pytest.approx(18 + 4 + 6)
    whole = run(Scene.from_table(table | longer | {"solver": steps}), folder / "whole")
    assert ended.history[-1]["tool_force"] == pytest.approx(whole.history[-1]["tool_force"], rel=0.02)


def test_a_run_that_goes_on_has_no_record_of_how_it_ended_before(folder, monkeypatch):
    """Killed then, its page would tell the reason of the stop before."""
    table = law_case() | {"output": {"picture": False, "report": False}}
    record, seen, accept = folder / "run" / "run.json", [], Simulation.accept
    run(Scene.from_table(table | {"solver": {"max_steps": 2}}), folder / "run")
    COMM.barrier()
    assert record.is_file()

    def looks(self, *args):
        seen.append(record.exists())
        accept(self, *args)

    monkeypatch.setattr(Simulation, "accept", looks)
    run(Scene.from_table(table | {"solver": {"max_steps": 4}}), folder / "run", restart=True)
    assert seen == [False, False]
    COMM.barrier()
    assert record.is_file()


def test_a_restart_without_a_checkpoint_says_that_it_begins_anew(folder, capfd):
    table = law_case() | {"output": {"picture": False, "report": False}, "solver": {"max_steps": 1}}
    run(Scene.from_table(table), folder / "run", restart=True)
    assert "no checkpoint" not in capfd.readouterr().out
    if COMM.rank == 0:
        (folder / "run" / NAME).unlink()
    COMM.barrier()
    run(Scene.from_table(table), folder / "run", restart=True)
    if COMM.rank == 0:
        assert "no checkpoint there yet: the run begins anew" in capfd.readouterr().out


def test_a_damaged_checkpoint_is_one_line(folder):
    table = law_case() | {"output": {"picture": False, "report": False}, "solver": {"max_steps": 2}}
    run(Scene.from_table(table), folder / "run")
    if COMM.rank == 0:
        content = (folder / "run" / NAME).read_bytes()
        (folder / "run" / NAME).write_bytes(content[: len(content) // 2])
    COMM.barrier()
    with pytest.raises(SceneError, match="cannot be read; expected the checkpoint of a run"):
        run(Scene.from_table(table), folder / "run", restart=True)
