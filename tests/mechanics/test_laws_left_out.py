"""Laws that a scene leaves out cost nothing: the equation has no field, constant, integral or operation of theirs."""

import ufl
from assembled import build
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.corealg.traversal import unique_pre_traversal

from ncf_fenicsx.laws.kinematics import in_plane

SMALL = {
    "gravity": "0 m/s^2",
    "duration": "1 s",
    "stack": {"layers": 1, "size": ["4 mm", "4 mm"], "divisions": [1, 1], "grading": [0.0, 0.0]},
}


def count(form):
    """Fields, constants, integrals and operations of a virtual work."""
    lowered = apply_derivatives(apply_algebra_lowering(form))
    nodes = [node for integral in lowered.integrals() for node in unique_pre_traversal(integral.integrand())]
    operations = sum(not node._ufl_is_terminal_ for node in nodes)
    return len(form.coefficients()), len(form.constants()), len(lowered.integrals()), operations


def problem_with(**laws):
    problem, _ = build(SMALL | {"laws": {"rate": {"kind": "none"}} | laws})
    return problem


def test_without_them_the_equation_is_that_of_fibres_compaction_and_shear_alone():
    problem = problem_with()
    material, u, v, dx = problem.material, problem.displacement, problem.variation, problem.volumes.all
    laws, kinematics = material.laws, material.kinematics(u)
    vf, initial = kinematics.volume_fraction, material.initial_volume_fraction
    stretch = ufl.derivative(kinematics.thickness_stretch, u, v)
    change = in_plane(ufl.sym(kinematics.deformation_gradient.T * ufl.grad(v)))
    by_hand = ufl.inner(laws.in_plane.stress(kinematics), change) * dx
    by_hand += -laws.compaction.pressure(vf, initial) * stretch * dx
    by_hand += ufl.derivative(laws.shear.energy(kinematics) * dx, u, v)
    assert list(problem.states) == ["volume_fraction"]
    assert count(problem.terms["internal"]) == count(by_hand)
    relaxing = problem_with(relaxation={"kind": "maxwell"})
    assert count(relaxing.terms["internal"]) > count(by_hand)
