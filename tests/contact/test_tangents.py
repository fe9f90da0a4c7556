"""The tangent of every contact is the derivative of its forces, whichever way it is enforced; forces balance."""

import numpy as np
import pytest
from assembled import COMM, assign, build, bumpy, forces, gradient_error, step_of

from ncf_fenicsx.mesh import compat

pytestmark = pytest.mark.two_ranks

SOFT = {"in_plane": {"modulus": "1 MPa"}}  # so that round-off of the fibres hides nothing else
WAYS = {
    "penalty": {},
    "nitsche": {"contact": {"kind": "nitsche"}},
    "skew nitsche": {"contact": {"kind": "nitsche", "variant": "skew"}},
    "symmetric nitsche": {"contact": {"kind": "nitsche", "variant": "symmetric"}},
    "augmented": {"contact": {"kind": "augmented_lagrangian"}},
    "friction": {"friction": {"coefficient": 0.3}},
    "augmented friction": {"contact": {"kind": "augmented_lagrangian"}, "friction": {"coefficient": 0.3}},
}
SYMMETRIC = ("penalty", "symmetric nitsche", "augmented", "stitched")
TOOLS = {
    "cylinder": {"kind": "cylinder", "width": "7 mm", "edge": "1 mm"},
    "sphere": {"kind": "sphere", "radius": "8 mm"},
    "foot": {"kind": "presser_foot", "size": ["8 mm", "8 mm"], "edge": "3 mm"},
    "profile": {"kind": "profile", "points": [["-4 mm", "3 mm"], ["0 mm", "0 mm"], ["4 mm", "2 mm"]]},
}


def pressed(table, **keys):
    """A problem half-way through a step in which everything moves, from a state that differs from the undeformed."""
    problem, newton = build(table | {"solver": {"tangent": "plain"}, "laws": SOFT} | keys)
    assign(problem, lambda x: 0.6 * bumpy(x) + np.stack([2e-5 * np.cos(400 * x[2]), 1e-5 * x[0] / 0.01, 0 * x[0]]))
    problem.contacts.refresh()
    step_of(problem).begin(0.0, 12.0)
    problem.clock.time_step.value, problem.clock.inverse_time_step.value = 0.5, 2.0
    for contact in (*problem.contacts.rigid, *problem.contacts.layers):
        if contact.multiplier is not None:
            contact.multiplier.state[0].values[:] = 3e3
        if contact.traction is not None:
            values = contact.traction.x.array
            values[:] = 500.0 * np.cos(np.arange(len(values)) // 3)
            if COMM.size > 1:
                values[:] = 300.0  # the same at a node on all ranks
    if problem.contacts.tools:
        problem.contacts.tools[0].tip.value[2] = 3.6e-3  # deep enough to touch the bumps
    assign(problem, bumpy)
    return problem, newton


def check_symmetry(problem, newton, way):
    """The program knows a symmetric tangent; stress in the pressure is never symmetric unless its variant is."""
    matrix = newton.tangent.assemble()
    difference = matrix.copy()
    difference.axpy(-1.0, matrix.copy().transpose())
    asymmetry = difference.norm() / matrix.norm()
    assert problem.symmetric == (way in SYMMETRIC)
    assert asymmetry < 1e-12 or not problem.symmetric
    assert asymmetry > 1e-9 or way not in ("nitsche", "skew nitsche")


@pytest.mark.parametrize("way", WAYS)
def test_tangent_of_a_tool(table, way):
    table["tool"] |= {"width": "7 mm"} | WAYS[way]
    problem, newton = pressed(table, interface={"kind": "bonded"})
    assert COMM.allreduce(np.count_nonzero(problem.contacts.tools[0].nodal_forces()[:, 2] > 0)) > 0
    assert gradient_error(problem, newton, 1e-9) < 1e-6
    check_symmetry(problem, newton, way)


@pytest.mark.parametrize("name", TOOLS)
def test_tangent_of_every_tool(table, name):
    table["tool"] = TOOLS[name] | {"friction": {"coefficient": 0.2}, "path": table["tool"]["path"]}
    problem, newton = pressed(table, interface={"kind": "bonded"})
    assert COMM.allreduce(np.count_nonzero(problem.contacts.tools[0].nodal_forces()[:, 2] > 0)) > 0
    assert gradient_error(problem, newton, 1e-9) < 1e-6


@pytest.mark.parametrize("kind", ["cylinder", "sphere", "plate"])
@pytest.mark.parametrize("way", ["penalty", "symmetric nitsche", "friction"])
def test_tangent_of_a_mould(table, kind, way):
    curved = {} if kind == "plate" else {"radius": "30 mm"}
    problem, newton = pressed(table, interface={"kind": "bonded"}, mould={"kind": kind} | curved | WAYS[way])
    problem.contacts.mould.tip.value[2] = 5e-5
    assert COMM.allreduce(np.count_nonzero(problem.contacts.mould.nodal_forces()[:, 2] < 0)) > 0
    assert gradient_error(problem, newton, 1e-9) < 1e-6
    check_symmetry(problem, newton, way)


LAYERS = WAYS | {"stitched": {"kind": "stitched", "yarn_stiffness": "100 N", "slip_share": 0.5}}
MESHES = {
    "matching": {"divisions": [6, 2]},
    "different": {"divisions": [[6, 2], [5, 3]]},
    "order 2": {"divisions": [[3, 1], [4, 2]], "order": 2},
}


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("way", LAYERS)
def test_tangent_between_layers(table, way, mesh):
    """Layers of equal and of different meshes, after a slip of a tenth of an element along x."""
    table["stack"] |= MESHES[mesh]
    del table["tool"]
    problem, newton = build(
        table | {"interface": LAYERS[way], "duration": "1 s", "laws": SOFT, "solver": {"tangent": "plain"}}
    )
    layer = problem.contacts.layers[0]
    assign(problem, bumpy)
    upper = problem.space.tabulate_dof_coordinates()[:, 2] > 2.1e-3
    upper |= np.isin(problem.contacts.body.spaces.numbers, layer.pairing.masters)
    problem.displacement.x.array.reshape(-1, 3)[upper, 0] += 2e-4
    problem.start.x.array[:] = problem.displacement.x.array
    problem.contacts.pair()
    if layer.multiplier is not None:
        layer.multiplier.state[0].values[:] = 3e3
    if layer.traction is not None:
        layer.traction.x.array[:] = 300.0
    newton.tangent.follow_links()
    problem.displacement.x.array.reshape(-1, 3)[upper, :2] += [3e-6, 2e-6]
    layer.refresh()
    gaps = np.concatenate(COMM.allgather(layer.gaps()))
    assert gaps.min() < 0 < gaps.max()
    assert COMM.allreduce(layer.pairing.rows.nnz) > COMM.allreduce(layer.pairing.rows.shape[0])
    assert gradient_error(problem, newton, 1e-9) < 1e-6
    check_symmetry(problem, newton, way)
    lower = forces(compat.compile_form(layer.term))[: problem.contacts.body.spaces.owned].sum(axis=0)
    upper = layer.residual()[1].sum(axis=0)
    size = COMM.allreduce(np.abs(layer.residual()[1]).sum())
    if way not in ("skew nitsche", "symmetric nitsche"):  # whose test functions see the stress, too
        assert np.abs(COMM.allreduce(lower + upper)).max() < 1e-12 * size
