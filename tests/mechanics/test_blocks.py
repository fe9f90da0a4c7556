"""Blocks that are sheared and strips that are bent as told: forces and moments are those of the tables."""

import numpy as np
import pytest
from assembled import COMM, assign, build, forces, step_of

from ncf_fenicsx.mesh import compat

pytestmark = pytest.mark.two_ranks


def bare(layers, size, divisions, thickness, laws):
    return {
        "gravity": "0 m/s^2",
        "duration": "1 s",
        "stack": {
            "layers": layers,
            "thickness": f"{thickness} mm",
            "areal_density": "1.385 kg/m^2",
            "fibre_density": "2.6e6 g/m^3",
            "size": size,
            "divisions": divisions,
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "bottom": "free"},
        },
        "interface": {"kind": "bonded"},
        "laws": laws,
    }


def nodal_forces(table, motion):
    """Forces in N and positions of the nodes that the rank owns, moved as told."""
    problem, _ = build(table)
    step_of(problem).begin(0.0, 1.0)
    assign(problem, motion)
    owned = problem.space.dofmap.index_map.size_local
    return forces(compat.compile_form(problem.terms["internal"]))[:owned], problem.space.tabulate_dof_coordinates()[
        :owned
    ]


@pytest.mark.parametrize(("angle", "kpa"), [(0.023, 3.7), (0.25, 16.9), (1.0, 31.9), (7.0, 61.9)])
def test_eighteen_plies_in_simple_shear_give_the_table_back(angle, kpa):
    slide = np.tan(np.radians(angle))
    table = bare(18, ["6 mm", "4 mm"], [2, 1], 1.0, {"shear": {"kind": "table"}, "rate": {"kind": "none"}})
    force, x = nodal_forces(table, lambda at: np.stack([slide * at[2], 0 * at[0], 0 * at[0]]))
    top = np.isclose(x[:, 2], 18e-3)
    stress = COMM.allreduce(float(force[top, 0].sum())) / (6e-3 * 4e-3)
    assert stress == pytest.approx(1e3 * kpa, rel=1e-3)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("curvature", "moment"), [(1.0, 0.11943), (2.29, 0.2735), (10.0, 0.349), (20.0, 0.383)])
def test_a_strip_bent_to_an_arc_gives_the_moment_of_the_table(curvature, moment, sign):
    """All normals stay normal on a circle; the moment about the axis is that of the forces on the end of an element."""
    kappa = sign * curvature
    table = bare(1, ["20 mm", "4 mm"], [10, 1], 1.0, {"bending": {"kind": "table"}, "rate": {"kind": "none"}})

    def arc(at):
        """Upper face stretched: the ends go down."""
        angle, height = kappa * at[0], at[2] - 0.5e-3
        return np.stack(
            [
                np.sin(angle) * (1 / kappa + height) - at[0],
                0 * at[0],
                np.cos(angle) * (1 / kappa + height) - 1 / kappa - height,
            ]
        )

    force, x = nodal_forces(table, arc)
    moved = x + arc(x.T).T
    end = np.isclose(x[:, 0], 20e-3)
    middle = np.array([np.sin(kappa * 20e-3) / kappa, 0, (np.cos(kappa * 20e-3) - 1) / kappa + 0.5e-3])
    about = np.cross(moved[end] - middle, force[end])[:, 1].sum()
    per_width = COMM.allreduce(float(about)) / 4e-3
    assert per_width == pytest.approx(sign * moment, rel=0.01)
