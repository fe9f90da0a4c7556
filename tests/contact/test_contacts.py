"""Stacks with an interface of its own for each pair of layers."""

import pytest
from assembled import COMM, build
from layers import ELASTIC, STITCH, simulate

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh import build_mesh

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


@pytest.mark.parametrize(
    ("kind", "gap", "cut"),
    [("penalty", 1e-7, True), ("nitsche", 1e-7, False), ("augmented_lagrangian", 1e-7, False), ("nitsche", 1e-5, True)],
)
def test_a_step_ends_where_a_free_tool_touches_but_some_press_over_a_gap(table, kind, gap, cut):
    path = table["tool"]["path"]
    table["tool"] = {"kind": "plate", "contact": {"kind": kind}, "clearance": f"{gap} m", "path": path}
    problem, _ = build(table)
    step = problem.contacts.longest_step(0.0, 1.0)
    assert (step < 1.0) == cut
    if cut:
        down = problem.contacts.tools[0].surface.path[0]
        assert step * down.speed == pytest.approx(gap, rel=0.05)
