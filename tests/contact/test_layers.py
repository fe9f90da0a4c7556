"""Layers on layers: uniform pressure through different meshes, bending, slip over elements, stitches, mixed ways."""

import numpy as np
import pytest
from assembled import COMM, build

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.simulation import Simulation

QUIET = {"picture": False}
ELASTIC = {"rate": {"kind": "none"}}
MESHES = {
    "matching": {"divisions": [6, 2]},
    "different": {"divisions": [[6, 2], [5, 3], [9, 4]]},
    "matching, order 2": {"divisions": [3, 1], "order": 2},
    "different, order 2": {"divisions": [[3, 1], [4, 2], [5, 3]], "order": 2},
}


def simulate(table, folder):
    """A run to its end, with its problem at hand."""
    simulation = Simulation(Scene.from_table(table | {"output": QUIET}), folder, COMM, overwrite=False)
    result = simulation.run()
    assert result.done, result.reason
    return simulation, result.history


def everywhere(values):
    return np.concatenate(COMM.allgather(np.asarray(values)))


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


def cantilever(layers, kind, load):
    """Strips of 10 cm a layer that neither shear nor lock: E/G (h/L)^2 / 3 and G/E (element/h)^2 are below 1 %."""
    table = {
        "gravity": "0 m/s^2",
        "laws": {
            "rate": {"kind": "none"},
            "in_plane": {"modulus": "100 GPa", "poisson": 0.0},
            "shear": {"modulus": "2 GPa"},
            "compaction": {"kind": "power", "scale": "10 GPa", "exponent": 1},
        },
        "stack": {
            "layers": layers,
            "size": [f"{100 * layers} mm", "2 mm"],
            "divisions": [75 * layers, 1],
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "y_max": "symmetry"},
        },
        "interface": {"kind": kind}
        | ({} if kind == "bonded" else {"penalty": "1e9 Pa/m" if load == "roller" else "1e7 Pa/m"}),
        "mould": {"kind": "plate", "clearance": "50 mm"},
        "solver": {"first_step": "6 s", "largest_step": "6 s"},
    }
    if load == "weight":
        return table | {"gravity": "9.81 m/s^2", "duration": "12 s"}
    path = [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]
    roller = {"width": "infinite", "position": [f"{100 * layers} mm", "0 mm"], "penalty": "1e10 Pa/m", "path": path}
    return table | {"tool": roller}


def flexibility(layers, kind, load, folder):
    """Deflection of the end over the load in m/N; all layers share the load, so they bend alike."""
    return bending_of(cantilever(layers, kind, load), folder)


def bending_of(table, folder):
    """Deflection of the end of a cantilever over its load in m/N."""
    layers, load = table["stack"]["layers"], "roller" if "tool" in table else "weight"
    simulation, history = simulate(table, folder)
    problem = simulation.problem
    places, u = problem.space.tabulate_dof_coordinates(), problem.displacement.x.array.reshape(-1, 3)
    end = np.isclose(places[:, 0], 0.1 * layers)
    heights, sinks = everywhere(places[end, 2]), everywhere(-u[end, 2])
    size = 2e-3
    middle = [np.abs(heights - size * (number + 0.5)) < 0.51 * size for number in range(layers)]
    by_layer = np.array([sinks[chosen].mean() for chosen in middle])
    assert np.ptp(by_layer) < 1e-2 * by_layer.mean()
    assert 1e-3 < by_layer.mean() / 2e-3 < 0.5
    assert history[-1].get("mould_contact_width", 0.0) == 0.0
    return by_layer.mean() / history[-1]["tool_force" if load == "roller" else "weight"]


@pytest.mark.parametrize(("layers", "load"), [(2, "roller"), (4, "roller"), (2, "weight"), (3, "weight")])
def test_n_frictionless_layers_have_the_nth_part_squared_of_the_bonded_stiffness(folder, layers, load):
    bonded, free = (flexibility(layers, kind, load, folder / kind) for kind in ("bonded", "one_sided"))
    assert free / bonded == pytest.approx(layers**2, rel=0.02)
    rigidity = 100e9 * 8e-3 * (2e-3 * layers) ** 3 / 12  # of the whole, four times the model's 2 mm
    exact = (0.1 * layers) ** 3 / ((8 if load == "weight" else 3) * rigidity)
    assert bonded == pytest.approx(exact, rel=0.02)


def test_a_tenth_of_the_elements_is_enough_with_order_2(folder):
    """With as many nodes, elements of order 1 lock: G / E (element / h)^2 stiffens them."""
    errors = []
    rigidity = 100e9 * 8e-3 * (2e-3) ** 3 / 12
    for order, elements in ((1, 16), (2, 8)):
        table = cantilever(1, "bonded", "roller")
        table["stack"] |= {"order": order, "divisions": [elements, 1]}
        exact = 0.1**3 / (3 * rigidity)
        errors.append(bending_of(table, folder / str(order)) / exact - 1)
    assert errors[1] == pytest.approx(0, abs=0.01)
    assert errors[0] < -0.1


PENALTY, PRESSED = 1e9, 1e-6
PARTS = {"matching": [6, 2], "different": [[6, 2], [5, 3]], "finer above": [[6, 2], [11, 5]]}


def two_layers(divisions, **interface):
    return {
        "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": divisions, "grading": [0, 0]},
        "interface": {"penalty": f"{PENALTY} Pa/m"} | interface,
        "duration": "1 s",
    }


def upper_nodes(problem):
    """Which local nodes belong to the upper of two layers, and which of them lie on the lower."""
    pairing = problem.contacts.layers[0].pairing
    facing = np.isin(problem.contacts.body.spaces.numbers, pairing.masters)
    return facing | (problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3), facing


def move(problem, upper, along=0.0, across=0.0, lift=0.0):
    problem.displacement.x.array.reshape(-1, 3)[upper] = (along, across, lift)


def applied(problem):
    """Forces in N on the upper nodes with their places in m, and on the lower ones, of all ranks."""
    layer, spaces = problem.contacts.layers[0], problem.contacts.body.spaces
    places = problem.space.tabulate_dof_coordinates() + problem.displacement.x.array.reshape(-1, 3)
    numbers, residual = layer.residual()
    everyone = dict(zip(everywhere(spaces.numbers), everywhere(places), strict=True))
    above = np.array([everyone[number] for number in numbers]).reshape(-1, 3)
    upper = COMM.allreduce(-residual.sum(axis=0)), COMM.allreduce(-np.cross(above, residual).sum(axis=0))
    form = layer.pressure_form
    pushes = np.zeros((len(places), 3))
    pushes[:, 2] = -layer.face.assembled(form)
    owned = slice(spaces.owned)
    moment = np.cross(places[owned], pushes[owned]).sum(axis=0)
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


STITCH = {"kind": "stitched", "yarn_stiffness": "8 N", "yarn_length": "2 mm", "pitch": ["4 mm", "10 mm"]}
OPENING = 8.0 / (2e-3 * 4e-3 * 10e-3)
"""EA / (length pitch pitch) in Pa/m."""


@pytest.mark.parametrize("divisions", PARTS.values(), ids=PARTS)
def test_stitches_pull_in_proportion_to_gap_and_slip(divisions):
    problem, _ = build(two_layers(divisions, **STITCH, slip_share=0.25))
    upper, _ = upper_nodes(problem)
    gap, slip, across = 0.3e-3, 0.2e-3, -0.1e-3
    move(problem, upper, slip, across, gap)
    problem.contacts.refresh()
    exact = -OPENING * 72e-6 * np.array([0.25 * slip, 0.25 * across, gap])
    residual = COMM.allreduce(problem.contacts.layers[0].residual()[1].sum(axis=0))
    assert -residual == pytest.approx(exact, rel=1e-10)


def slip_to(problem, upper, slip):
    """An accepted step to a slip in m, the layers a tenth of a millimetre apart; the pull on the upper one in N."""
    move(problem, upper, slip, 0.0, 0.1e-3)
    problem.contacts.refresh()
    problem.commit(1.0)
    return -COMM.allreduce(problem.contacts.layers[0].residual()[1].sum(axis=0))


@pytest.mark.parametrize("divisions", PARTS.values(), ids=PARTS)
def test_stitches_remember_a_slip_over_elements(divisions):
    """The pull grows by the slip of each step, on what overlaps then."""
    problem, _ = build(two_layers(divisions, **STITCH, slip_share=0.25))
    layer, (upper, _) = problem.contacts.layers[0], upper_nodes(problem)
    for slip in 0.45e-3 * np.arange(1, 8):
        pull = slip_to(problem, upper, slip)
        overlap = (12e-3 - slip) * 6e-3
        assert pull == pytest.approx(-OPENING * overlap * np.array([0.25 * slip, 0, 0.1e-3]), rel=1e-8, abs=1e-9)
        slips = np.linalg.norm(layer.slip, axis=1)[layer.face.owned()]
        assert max(COMM.allgather(slips.max(initial=0.0))) == pytest.approx(slip, rel=1e-9)


def test_stitches_are_slack_again_when_the_layers_are_back():
    """Also those at the edge that faced nothing on the way."""
    problem, _ = build(two_layers(PARTS["different"], **STITCH, slip_share=0.25))
    upper, _ = upper_nodes(problem)
    out = [slip_to(problem, upper, slip) for slip in (1e-3, 2e-3, 3e-3)]
    back = [slip_to(problem, upper, slip) for slip in (2e-3, 1e-3, 0.0)]
    assert back[0] == pytest.approx(out[1], rel=1e-6)
    assert back[1] == pytest.approx(out[0], rel=1e-6)
    assert abs(back[2][0]) < 1e-6 * abs(out[0][0])


WAYS = [{"kind": "bonded"}, {"kind": "one_sided"}, STITCH | {"slip_share": 0.0, "yarn_stiffness": "0.02 N"}]


def mixed(layers, ways):
    return {
        "stack": {"layers": layers, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "through": 2, "grading": [0, 0]},
        "interface": ways,
        "duration": "1 s",
    }


@pytest.mark.parametrize("first", range(3))
def test_a_list_of_interfaces_builds_what_it_says(first):
    ways = WAYS[first:] + WAYS[:first]
    scene = Scene.from_table(mixed(4, ways))
    stack = build_mesh(scene, COMM)
    assert stack.mesh.topology.index_map(0).size_global == 7 * 3 * (4 * 3 - 1)
    open_ = [number for number, way in enumerate(ways) if way["kind"] != "bonded"]
    assert stack.open_interfaces == open_
    problem, _ = build(mixed(4, ways))
    built = [
        (layer.settings.kind, face.layer) for layer in problem.contacts.layers for face in layer.pairing.interfaces
    ]
    assert sorted(built, key=lambda entry: entry[1]) == [(ways[number]["kind"], number) for number in open_]
    assert set(problem.terms) == {"internal", "gravity", "interface", "interface_2"}


def test_equal_interfaces_are_one_and_a_bonded_stack_has_none():
    problem, _ = build(mixed(4, [WAYS[1], WAYS[2], WAYS[1]]))
    assert [[face.layer for face in layer.pairing.interfaces] for layer in problem.contacts.layers] == [[0, 2], [1]]
    alone, _ = build(mixed(4, WAYS[0]))
    assert alone.space.dofmap.index_map.size_global == 7 * 3 * 9
    assert not alone.contacts.layers


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


def test_layers_that_hang_part_only_where_they_may(folder):
    """Clamped strips, the lower the more flexible, sag by their weight: bonds hold, stitches give, the rest opens."""
    plies = [[90], [90, 90, 0], [90, 0], [0]]
    families = {"kind": "fibre_families", "modulus": "1 GPa", "modulus_compression": "1 GPa", "shear_modulus": "1 MPa"}
    table = {
        "laws": ELASTIC | {"in_plane": families | {"plies": plies}, "shear": {"modulus": "10 MPa"}},
        "stack": {
            "layers": 4,
            "size": ["60 mm", "2 mm"],
            "divisions": [30, 1],
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "y_max": "symmetry"},
        },
        "mould": {"kind": "plate", "clearance": "50 mm"},
        "duration": "1 s",
        "solver": {"first_step": "1 s", "largest_step": "1 s"},
    }
    opened = {}
    for name, ways in {"mixed": WAYS, "free": "one_sided", "tight": "bonded"}.items():
        kinds = {"kind": ways} if isinstance(ways, str) else ways
        _, history = simulate(table | {"interface": kinds}, folder / name)
        opened[name] = [history[-1].get(f"gap_max_{number}") for number in (1, 2, 3)]
    assert opened["tight"] == [None] * 3
    assert opened["mixed"][0] is None
    assert min(opened["free"]) > 1e-6
    assert opened["mixed"][1] > 1e-6
    assert 1e-9 < opened["mixed"][2] < 0.5 * opened["free"][2]
