"""Laws at work in whole runs: histories against exact solutions, a new law in the roller scene, permeability fields."""

import meshio
import numpy as np
import pytest
from laws_by_number import VF0, march
from mpi4py import MPI
from program import DEMOS

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.laws.compaction import CompactionLaw, Exponential
from ncf_fenicsx.laws.in_plane import HyperelasticInPlaneLaw
from ncf_fenicsx.laws.permeability import Gebart
from ncf_fenicsx.parameters.kinds import _kinds

pytestmark = pytest.mark.two_ranks

COMM = MPI.COMM_WORLD


def plate(path, laws, permeability=None, **solver):
    """One layer without weight under a flat plate."""
    output = (
        {"picture": False, "report": False}
        if permeability is None
        else {"picture": False, "report": False, "permeability": permeability}
    )
    return Scene.from_table(
        {
            "gravity": "0 m/s^2",
            "stack": {"layers": 1, "size": ["4 mm", "2 mm"], "divisions": [3, 2]},
            "laws": laws,
            "tool": {"kind": "plate", "penalty": 100.0, "path": path},
            "solver": {"force_tolerance": 1e-11, "time_tolerance": 1.0} | solver,
            "output": output,
        }
    )


def press(millimetres, speed="2 mm/min"):
    return {"travel": ["0 mm", "0 mm", f"{-millimetres} mm"], "speed": speed}


def columns(result, *names):
    return [np.array([row[name] for row in result.history]) for name in names]


def pressure_of(result):
    return columns(result, "tool_force")[0] / (4 * 8e-6)


CYCLE = [press(0.5), {"hold": "5 s"}, press(-0.45), {"hold": "3 s"}, press(0.6, "5 mm/min"), press(-1)]
LOCAL = {"feed": "local"}
RELAXATION = {"branches": [{"share": 0.3, "time": "2 s"}, {"share": 0.2, "time": "30 s"}]}


@pytest.mark.parametrize(
    "laws",
    [
        {"rate": LOCAL},
        {"rate": {"kind": "none"}, "relaxation": RELAXATION},
        {"rate": {"kind": "none"}, "unloading": {}},
        {"rate": LOCAL, "relaxation": RELAXATION, "unloading": {"set_share": 0.7}},
        {"rate": LOCAL | {"exponent": "as_printed", "reference_thickness": "1 mm"}, "compaction": {"kind": "gutowski"}},
        {"rate": {"kind": "none"}, "compaction": {"kind": "table"}, "unloading": {}},
        {"rate": {"kind": "table"}, "unloading": {"kind": "pressure_set"}, "relaxation": {}},
    ],
    ids=["rate", "relaxation", "unloading", "all", "printed rate", "table", "tables and decades"],
)
@pytest.mark.serial
def test_a_cycle_under_a_plate_follows_the_laws_step_by_step(laws, folder):
    """Press, hold, lift, press harder, lift off: the force is the laws' own at the Vf and times of the run."""
    scene = plate(CYCLE, laws)
    result = run(scene, folder)
    assert result.done, result.reason
    time, low, vf = columns(result, "time", "vf_min", "vf_max")
    assert low == pytest.approx(vf, rel=1e-8)
    stateful = scene.laws.stateful
    expected = march(stateful, scene.laws.compaction, list(zip(time, vf, strict=True)), scene.laws.rate)
    loaded = pressure_of(result)
    assert loaded.max() > 1e4
    assert loaded == pytest.approx(expected, rel=1e-7, abs=1e-6 * loaded.max())
    assert loaded[-1] == 0  # lifted off
    if COMM.rank == 0:
        files = sorted((folder / "fields").glob("*.vtu"))
        stress = [meshio.read(file).cell_data_dict["stress_33"]["hexahedron"] for file in files]
        assert np.concatenate(stress) == pytest.approx(np.repeat(-expected, 6), rel=1e-6, abs=1e-6 * loaded.max())


@pytest.mark.serial
def test_a_hold_decays_as_the_exact_solution(folder):
    """Pressed fast and held: p + sum of p share exp(-t / time), the plate's own penetration aside."""
    laws = {"rate": {"kind": "none"}, "relaxation": RELAXATION}
    result = run(plate([press(0.5, "100 mm/min"), {"hold": "60 s"}], laws), folder)
    time, vf = columns(result, "time", "vf_max")
    held = time > 0.3
    slow = Exponential().pressure(vf[held], VF0)
    since = time[held] - 0.2  # most of the pressure came in the last third of the press
    expected = slow * (1 + 0.3 * np.exp(-since / 2) + 0.2 * np.exp(-since / 30))
    assert pressure_of(result)[held] == pytest.approx(expected, rel=0.02)
    assert pressure_of(result)[-1] < 0.75 * pressure_of(result).max()


@pytest.mark.serial
def test_the_force_of_a_ramp_is_of_order_two_in_the_time_step(folder):
    laws = {"rate": {"kind": "none"}, "relaxation": {"branches": [{"share": 2.0, "time": "3 s"}]}}
    forces, steps = [], (4, 8, 16, 128)
    for number in steps:
        size = f"{6 / number} s"
        scene = plate([press(0.5, "5 mm/min")], laws, first_step=size, largest_step=size, growth=1.0)
        result = run(scene, folder / str(number))
        assert len(result.history) == number + 1
        forces.append(result.history[-1]["tool_force"])
    errors = np.abs(np.array(forces[:-1]) - forces[-1])
    order = np.polyfit(np.log(steps[:-1]), np.log(errors), 1)[0]
    assert -2.3 < order < -1.8


@pytest.mark.serial
def test_the_set_stays_when_the_tool_lifts(folder):
    laws = {"rate": {"kind": "none"}, "unloading": {"set_share": 0.5}}
    result = run(plate([press(0.5), press(-1)], laws), folder)
    (vf,) = columns(result, "vf_max")
    assert vf[-1] == pytest.approx(VF0 + 0.5 * (vf.max() - VF0), rel=1e-6)


def test_laws_defined_here_run_in_the_roller_scene(folder):
    class Linear(CompactionLaw):
        kind = "linear_of_this_test"

        def pressure(self, volume_fraction, initial_volume_fraction):
            return 1e5 * (volume_fraction - initial_volume_fraction)

    class Quadratic(HyperelasticInPlaneLaw):
        kind = "quadratic_of_this_test"

        @property
        def stiffness(self):
            return 242e9

        def energy(self, in_plane_cauchy_green):
            C = in_plane_cauchy_green
            return 242e9 / 8 * ((C[0, 0] - 1) ** 2 + (C[1, 1] - 1) ** 2 + 0.8 * C[0, 1] * C[1, 0])

    coarse = ["stack.divisions=[12, 6]", "output.picture=false", "output.report=false"]
    try:
        usual = run(Scene.read(DEMOS / "roller.toml", coarse), folder / "usual")
        for family, kind in (("compaction", Linear.kind), ("in_plane", Quadratic.kind)):
            changed = Scene.read(DEMOS / "roller.toml", [*coarse, f"laws.{family}={{kind='{kind}'}}"])
            result = run(changed, folder / family)
            assert result.done
            ratio = result.history[-1]["tool_force"] / usual.history[-1]["tool_force"]
            assert 0.1 < ratio < 10
            assert abs(ratio - 1) > 0.01
    finally:
        del _kinds["compaction"][Linear.kind], _kinds["in_plane"][Quadratic.kind]


def test_permeability_is_a_field_of_the_cells(table, folder):
    table["output"] |= {"permeability": {"packing": "quadratic"}}
    run(Scene.from_table(table), folder)
    if COMM.rank == 0:
        last = meshio.read(sorted((folder / "fields").glob("*.vtu"))[-1]).cell_data_dict
        vf = last["volume_fraction"]["hexahedron"]
        law = Gebart(packing="quadratic")
        assert last["permeability_along"]["hexahedron"] == pytest.approx(law.along(vf), rel=1e-12)
        assert last["permeability_across"]["hexahedron"] == pytest.approx(law.across(vf), rel=1e-12)


def test_a_run_ends_before_the_packing_limit_and_says_where(folder):
    """Gebart's quadratic packing ends at Vf = 0.785: pressed beyond, the run stops there with its fields in order."""
    scene = plate([press(1.4)], {}, smallest_step="0.5 s", force_tolerance=1e-7, permeability={"packing": "quadratic"})
    result = run(scene, folder)
    assert not result.done
    assert "fibre volume fraction outside (0, 0.7854) (output.permeability, gebart) at" in result.reason
    assert "mm in layer 1" in result.reason
    assert 0.7 < result.history[-1]["vf_max"] < np.pi / 4


@pytest.mark.serial
def test_gutowskis_limit_locks_the_fabric(folder):
    scene = plate([press(1.4)], {"compaction": {"kind": "gutowski", "limit": 0.6}}, force_tolerance=1e-7)
    result = run(scene, folder)
    vf, force = columns(result, "vf_max", "tool_force")
    assert np.all(vf < 0.6)
    assert force[-1] > 1e3 * force[vf < 0.5][-1]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            {"output": {"permeability": {"packing": "quadratic"}}},
            "output.permeability.kind = 'gebart': expected a packing",
        ),
        (
            {"laws": {"compaction": {"kind": "gutowski", "limit": 0.5}}},
            "laws.compaction.limit = 0.5: expected above Vf0",
        ),
    ],
)
def test_a_fabric_denser_than_the_packing_limit_is_refused(table, words):
    dense = {"duration": "1 s", "stack": {"areal_density": "2.9 kg/m^2"}}
    with pytest.raises(SceneError) as caught:
        Scene.from_table(dense | table)
    assert words in str(caught.value)
