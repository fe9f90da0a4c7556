"""What `check` counts from a scene is what the mesh has, and what it says of tools is what the whole mesh says."""

import itertools

import numpy as np
import pytest
from mpi4py import MPI
from program import SMALL_STACK

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.mesh import build_mesh, compat, stack_mesh, stack_size
from ncf_fenicsx.mesh.hexahedra import lower_tag
from ncf_fenicsx.mesh.stack_size import size_of
from ncf_fenicsx.mesh.tool_placement import placement_cautions
from ncf_fenicsx.mesh.wave_resolution import wave_cautions
from ncf_fenicsx.simulation.preview import preview

pytestmark = pytest.mark.serial

INTERFACES = {
    "separate": {"kind": "one_sided"},
    "bonded": {"kind": "bonded"},
    "mixed": [{"kind": "bonded"}, {"kind": "one_sided"}],
    "mixed, the other way": [{"kind": "stitched"}, {"kind": "bonded"}],
}
DIVISIONS = {"all": [5, 3], "apart": [[4, 2], [4, 2], [7, 3]], "each": [[4, 2], [3, 3], [1, 1]]}
THROUGH = {"one": 1, "each": [2, 1, 3]}
COMBINATIONS = [
    combination
    for combination in itertools.product([1, 2], INTERFACES, DIVISIONS, THROUGH)
    if combination[1] == "separate" or combination[2] == "all" or (combination[1:3] == ("mixed", "apart"))
]


@pytest.mark.parametrize("combination", COMBINATIONS, ids=str)
def test_what_is_counted_is_what_is_built(combination):
    order, interface, divisions, through = combination
    settings = {"layers": 3, "order": order, "divisions": DIVISIONS[divisions], "through": THROUGH[through]}
    scene = Scene.from_table({"duration": "1 s", "stack": settings, "interface": INTERFACES[interface]})
    stack, size = build_mesh(scene, MPI.COMM_SELF), size_of(scene)
    assert size.cells == len(stack.layer)
    assert size.nodes == stack.numbers.max() + 1
    assert size.facing == sum(len(stack.facets(lower_tag(layer))) for layer in stack.open_interfaces)


def test_a_mesh_file_is_counted_as_it_is():
    for order, interface in itertools.product([1, 2], ["one_sided", "bonded"]):
        settings = {"layers": 2, "order": order, "mesh": str(SMALL_STACK)}
        scene = Scene.from_table({"duration": "1 s", "stack": settings, "interface": {"kind": interface}})
        stack, size = build_mesh(scene, MPI.COMM_SELF), size_of(scene)
        assert (size.cells, size.nodes) == (len(stack.layer), stack.numbers.max() + 1)
        assert size.facing == sum(len(stack.facets(lower_tag(layer))) for layer in stack.open_interfaces)


def test_nothing_is_built_for_a_preview(monkeypatch):
    def fail(*_):
        raise AssertionError("a mesh was built")

    for place, name in ((stack_size, "stack_of"), (stack_mesh, "_extruded"), (compat, "create_hexahedral_mesh")):
        monkeypatch.setattr(place, name, fail)
    scene = Scene.from_table({"tool": {}, "stack": {"divisions": [30_000_000, 1_000_000]}})
    lines = preview(scene)
    assert f"unknowns: {3 * 4 * 2 * 30_000_001 * 1_000_001}\n" in lines
    assert "expected memory: 5.3e+09 GB" in lines


def grids(random):
    """Random scenes with a tool on its way over many elements, a mould below."""
    mm = [f"{value:.3f} mm" for value in random.uniform(0, 60, 4)]
    way = {"travel": [f"{random.uniform(-20, 20):.3f} mm", f"{random.uniform(-20, 20):.3f} mm", "0 mm"]}
    kind = random.choice(["cylinder", "sphere", "presser_foot", "profile"])
    stack = {
        "layers": 2,
        "divisions": [[int(n) for n in random.integers(1, 200, 2)], [int(n) for n in random.integers(1, 200, 2)]],
        "grading": [float(g) for g in random.uniform(0, 0.95, 2)],
        "focus": mm[:2],
    }
    tool = {"kind": kind, "position": mm[2:], "path": [way | {"speed": "1 mm/s"}]}
    laws = {"bending": {"modulus": "1 MPa"}, "shear": {"modulus": "5 MPa"}}
    return {
        "stack": stack,
        "tool": tool,
        "mould": {"kind": "sphere", "position": mm[1:3], "radius": "9 mm"},
        "laws": laws,
    }


@pytest.mark.parametrize("seed", range(60))
def test_a_few_cells_say_of_tools_what_all_say(seed):
    scene = Scene.from_table(grids(np.random.default_rng(seed)))
    stack = stack_mesh.stack_of(scene)
    assert size_of(scene).cautions == [*placement_cautions(scene, stack), *wave_cautions(scene, stack)]


def test_some_of_those_scenes_have_cautions_of_each_sort():
    words = [" ".join(size_of(Scene.from_table(grids(np.random.default_rng(seed)))).cautions) for seed in range(60)]
    for sort in ("off the stack", "under tool", "under mould", "along x", "along y", "ask for elements"):
        assert 5 < sum(sort in text for text in words) < 60, sort


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("divisions", [[6, 2], [3000, 2000]])
def test_a_mould_that_cuts_into_the_stack_is_told_how_far_to_go_down(table, order, divisions):
    table["mould"] = {"kind": "sphere", "shape": "concave", "radius": "50 mm"}
    table["stack"] |= {"divisions": divisions, "order": order}
    with pytest.raises(SceneError, match=r"mould.clearance = 0 mm: it starts .* expected at least 1.8337"):
        size_of(Scene.from_table(table))
    table["mould"]["clearance"] = "1.8337 mm"
    size_of(Scene.from_table(table))


def test_what_no_mesh_can_be_built_of_is_one_line(table):
    bonded = table | {"interface": {"kind": "bonded"}, "stack": table["stack"] | {"divisions": [[4, 2], [5, 2]]}}
    thin = table | {"stack": table["stack"] | {"focus": ["1e-25 m", "0 mm"]}}
    for refused, words in ((bonded, "layers 1 and 2 are bonded; expected facets that match"), (thin, "degenerate")):
        for judge in (size_of, stack_mesh.stack_of):
            with pytest.raises(SceneError, match=words):
                judge(Scene.from_table(refused))
