"""Layers on layers: uniform pressure through different meshes, slip over elements, a tool that lifts."""

import numpy as np
import pytest
from assembled import COMM, build
from layers import ELASTIC, PARTS, PENALTY, PRESSED, everywhere, move, simulate, two_layers, upper_nodes

MESHES = {
    "matching": {"divisions": [6, 2]},
    "different": {"divisions": [[6, 2], [5, 3], [9, 4]]},
    "matching, order 2": {"divisions": [3, 1], "order": 2},
    "different, order 2": {"divisions": [[3, 1], [4, 2], [5, 3]], "order": 2},
}


def pressed_by_a_plate(way, mesh, **laws):
    return {
        "gravity": "0 m/s^2",
        "laws": ELASTIC | laws,
        "stack": {"layers": 3, "size": ["12 mm", "6 mm"], "grading": [0, 0]} | MESHES[mesh],
        "interface": {"contact": {"kind": way}},
        "tool": {
            "kind": "plate",
            "contact": {"kind": way},
            "path": [{"travel": ["0 mm", "0 mm", "-0.6 mm"], "speed": "1 mm/min"}],
        },
        "solver": {"force_tolerance": 1e-11, "first_step": "12 s", "largest_step": "12 s"},
    }


def check_uniform_pressure(simulation, history, error):
    """The law's pressure at the stack's Vf is the stress of every cell, and the pressure on every face."""
    scene, measures = simulation.scene, simulation.measures
    stress = everywhere(measures.cells["stress_33"])
    vf = history[-1]["vf_mean"]
    expected = scene.laws.compaction.pressure(vf, scene.stack.initial_volume_fraction)
    assert expected > 1e3
    assert np.abs(stress / -expected - 1).max() < error
    assert history[-1]["tool_force"] / (4 * 72e-6) == pytest.approx(expected, rel=error)
    pressures = measures.contacts.nodes["contact_pressure"]
    contacts = simulation.problem.contacts
    for face in (contacts.tools[0].face, contacts.layers[0].face):
        nodes = face.owned()
        assert COMM.allreduce(len(nodes)) >= 7 * 3
        assert np.abs(pressures[nodes] / expected - 1).max(initial=0.0) < error


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("way", ["penalty", "nitsche", "augmented_lagrangian"])
def test_a_uniform_pressure_passes_through_layers_of_any_meshes(folder, way, mesh):
    check_uniform_pressure(*simulate(pressed_by_a_plate(way, mesh), folder), 1e-8)


@pytest.mark.parametrize("mesh", MESHES)
def test_a_soft_weightless_stack_rests_and_passes_a_uniform_pressure_on(folder, mesh):
    """Round-off of the contacts alone is above that of such soft fibres."""
    table = pressed_by_a_plate("penalty", mesh, in_plane={"modulus": "1 MPa"})
    table["solver"]["force_tolerance"] = 1e-9
    check_uniform_pressure(*simulate(table, folder), 1e-8)


def applied(problem):
    """Forces in N on the upper nodes with their positions in m, and on the lower ones, of all ranks."""
    layer, spaces = problem.contacts.layers[0], problem.contacts.body.spaces
    positions = problem.space.tabulate_dof_coordinates() + problem.displacement.x.array.reshape(-1, 3)
    numbers, residual = layer.residual()
    everyone = dict(zip(everywhere(spaces.numbers), everywhere(positions), strict=True))
    above = np.array([everyone[number] for number in numbers]).reshape(-1, 3)
    upper = COMM.allreduce(-residual.sum(axis=0)), COMM.allreduce(-np.cross(above, residual).sum(axis=0))
    form = layer.pressure_form
    pushes = np.zeros((len(positions), 3))
    pushes[:, 2] = -layer.face.assembled(form)
    owned = slice(spaces.owned)
    moment = np.cross(positions[owned], pushes[owned]).sum(axis=0)
    return upper, (COMM.allreduce(pushes[owned].sum(axis=0)), COMM.allreduce(moment))


@pytest.mark.parametrize("divisions", PARTS.values(), ids=PARTS)
@pytest.mark.parametrize("elements", [0.0, 0.3, 1.0, 1.7, -1.7])
def test_layers_that_slipped_by_elements_push_where_they_overlap(elements, divisions):
    problem, _ = build(two_layers(divisions))
    layer, slip = problem.contacts.layers[0], elements * 2e-3
    upper, _ = upper_nodes(problem)
    move(problem, upper, slip, 0.0, -PRESSED)
    problem.start.x.array[:] = problem.displacement.x.array
    layer.update()
    (force, moment), (below, moment_below) = applied(problem)
    overlap = 12e-3 - abs(slip)
    exact = PENALTY * PRESSED * overlap * 6e-3
    centre = 6e-3 + slip / 2
    assert force == pytest.approx([0, 0, exact], rel=1e-9, abs=1e-9 * exact)
    assert below == pytest.approx([0, 0, -exact], rel=1e-9, abs=1e-9 * exact)
    assert moment[1] == pytest.approx(-centre * exact, rel=1e-9)
    assert moment[0] == pytest.approx(3e-3 * exact, rel=1e-9)
    assert moment + moment_below == pytest.approx(np.zeros(3), abs=1e-9 * 12e-3 * exact)
    gaps, nodes = layer.gaps(), layer.face.owned()
    covered = nodes[~layer._uncovered[nodes]]
    assert COMM.allreduce(len(covered)) >= 21 - 3 * np.ceil(abs(elements))
    assert gaps[covered] == pytest.approx(-PRESSED, rel=1e-8)
    assert not gaps[np.setdiff1d(nodes, covered)].any()


def test_a_slip_within_the_snap_acts_hardly_aside():
    """Up to a twentieth of an element nodes stay with their partners: as much is the force's arm off."""
    problem, _ = build(two_layers([6, 2]))
    upper, _ = upper_nodes(problem)
    move(problem, upper, 0.04 * 2e-3, 0.0, -PRESSED)
    problem.start.x.array[:] = problem.displacement.x.array
    problem.contacts.layers[0].update()
    (force, moment), (below, moment_below) = applied(problem)
    assert force + below == pytest.approx(np.zeros(3), abs=1e-12)
    assert force[2] == pytest.approx(PENALTY * PRESSED * 72e-6, rel=1e-9)
    assert abs((moment + moment_below)[1]) <= 0.05 * 2e-3 * force[2]


def test_a_soft_layer_is_dragged_over_another_by_more_than_an_element(folder):
    """A foot with friction stretches the upper layer along x; the lower one stays. Forces balance in every step."""
    table = {
        "laws": ELASTIC
        | {
            "in_plane": {
                "kind": "fibre_families",
                "plies": [[0], [90]],
                "modulus": "1 GPa",
                "modulus_compression": "0.1 GPa",
                "shear_modulus": "20 kPa",
            }
        },
        "stack": {
            "layers": 2,
            "size": ["20 mm", "3 mm"],
            "divisions": [[20, 1], [18, 1]],
            "grading": [0, 0],
            "sides": {"y_max": "symmetry"},
        },
        "tool": {
            "kind": "presser_foot",
            "size": ["32 mm", "30 mm"],
            "friction": {"coefficient": 0.6},
            "penalty": 30.0,
            "path": [
                {"travel": ["0 mm", "0 mm", "-0.6 mm"], "speed": "2 mm/min"},
                {"travel": ["2 mm", "0 mm", "0 mm"], "speed": "2 mm/min"},
            ],
        },
        "solver": {"first_step": "6 s", "largest_step": "6 s"},
    }
    simulation, history = simulate(table, folder)
    assert max(row["slip_max_1"] for row in history) > 1.2e-3
    for row in history:
        missing = row["support_force"] - row["weight"] - row["tool_force"]
        assert abs(missing) < 1e-6 * max(row["tool_force"], row["weight"])
    layer, copies = simulation.problem.contacts.layers[0], simulation.scene.stack.sides.copies
    below, above = (copies * COMM.allreduce(float(part)) for part in between(layer))
    assert below == pytest.approx(above, rel=1e-10)
    assert below == pytest.approx(history[-1]["tool_force"] + history[-1]["weight"] / 2, rel=0.2)


def between(layer):
    """Upward forces in N on the lower face (its sign turned) and on the upper one, of this rank."""
    nodes = layer.face.owned()
    normals = layer._normal.x.array.reshape(-1, 3)
    pressure = layer.face.assembled(layer.pressure_form)
    return (pressure[nodes] * normals[nodes, 2]).sum(), -layer.residual()[1][:, 2].sum()


def test_a_layer_that_springs_back_from_a_lifted_tool_is_not_thrown_off_the_one_below(folder):
    """Carried on, its last motion would open all of the interface, and nothing hold the upper layer."""
    down = {"travel": ["0 mm", "0 mm", "-0.3 mm"], "speed": "1 mm/min"}
    up = {"travel": ["0 mm", "0 mm", "0.2 mm"], "speed": "2 mm/min"}
    table = {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0, 0]},
        "tool": {"kind": "plate", "path": [down, up]},
        "laws": {"unloading": {"kind": "permanent_set"}},
        "solver": {"largest_step": "3 s"},
    }
    history = simulate(table, folder)[1]
    lifted = [row for row in history if row["time"] > 20 and not row["tool_force"]]
    assert lifted
    assert max(row["newton_iterations"] for row in lifted) <= 6
    assert not sum(row["step_cuts"] for row in lifted)
