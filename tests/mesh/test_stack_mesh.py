"""The extruded stack: its volume, faces and pairs."""

import numpy as np
import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.mesh.hexahedra import TAGS, lower_tag, upper_tag

COMM = MPI.COMM_WORLD


@pytest.mark.parametrize("kind", ["one_sided", "bonded"])
def test_volume_faces_and_pairs_of_an_extruded_stack(kind):
    from dolfinx import fem
    from ufl import Measure

    table = {"tool": {}, "stack": {"divisions": [5, 4], "through": [1, 2, 1, 1]}, "interface": {"kind": kind}}
    stack = build_mesh(Scene.from_table(table), COMM)
    ds = Measure("ds", domain=stack.mesh, subdomain_data=stack.facet_tags)
    one = fem.Constant(stack.mesh, 1.0)

    def area(tag):
        return COMM.allreduce(fem.assemble_scalar(fem.form(one * ds(tag))))

    side, square = 0.076 * 0.008, 0.076**2
    expected = {"bottom": square, "top": square, "x_min": side, "x_max": side, "y_min": side, "y_max": side}
    for name, value in expected.items():
        assert area(TAGS[name]) == pytest.approx(value, rel=1e-12), name
    assert area(TAGS["sides"]) == 0
    for layer in range(3):
        for tag in (lower_tag(layer), upper_tag(layer)):
            assert area(tag) == pytest.approx(square if kind == "one_sided" else 0.0, rel=1e-12)
    assert stack.open_interfaces == ([0, 1, 2] if kind == "one_sided" else [])
    assert COMM.allreduce(np.bincount(stack.layer, minlength=4)) == pytest.approx([20, 40, 20, 20])
