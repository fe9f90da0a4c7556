"""Elasticity of fibres in their plane against finite differences, closed forms and each other."""

import numpy as np
import pytest
import ufl
from laws_by_number import DEFORMATIONS, numbers, strained

from ncf_fenicsx.laws.in_plane import FibreFamilies, NeoHookean, NeoHookeanAsPrinted
from ncf_fenicsx.laws.law import number

pytestmark = pytest.mark.serial
HYPERELASTIC = [
    NeoHookean(),
    NeoHookean(poisson=-0.3),
    FibreFamilies(),
    FibreFamilies(plies=(30.0,), shear_modulus="3 GPa", transition=0.01),
]


def in_plane_energy(made, c):
    return number(made.energy(ufl.as_matrix(c.tolist())))


@pytest.mark.parametrize("made", HYPERELASTIC, ids=lambda made: f"{made.kind}")
@pytest.mark.parametrize("F", DEFORMATIONS)
def test_in_plane_stress_is_the_derivative_of_its_energy(made, F):
    c, step = (F.T @ F)[:2, :2], 1e-6
    stress = numbers(made.stress(strained(F)))
    for i, j in np.ndindex(2, 2):
        change = np.zeros((2, 2))
        change[i, j] += step / 2
        change[j, i] += step / 2
        slope = (in_plane_energy(made, c + change) - in_plane_energy(made, c - change)) / (2 * step)
        assert stress[i, j] == pytest.approx(2 * slope, rel=1e-6, abs=1e-8 * made.stiffness)


def test_the_neo_hookean_stress_is_the_textbook_one():
    made, F = NeoHookean(), DEFORMATIONS[0]
    c = (F.T @ F)[:2, :2]
    mu, lame = made.modulus / 2 / (1 + made.poisson), made.modulus * made.poisson / (1 - made.poisson**2)
    expected = mu * (np.eye(2) - np.linalg.inv(c)) + lame * np.log(np.linalg.det(c)) / 2 * np.linalg.inv(c)
    assert numbers(made.stress(strained(F))) == pytest.approx(expected, rel=1e-12)


def test_a_pulled_strip_has_the_modulus_and_poisson_ratio_it_is_given():
    made, strain = NeoHookean(), 1e-6
    stress = numbers(made.stress(strained(np.diag([1 + strain, 1 - made.poisson * strain, 1.0]))))
    assert stress[0, 0] == pytest.approx(made.modulus * strain, rel=1e-5)
    assert abs(stress[1, 1]) < 1e-5 * made.modulus * strain


@pytest.mark.parametrize("F", DEFORMATIONS)
def test_the_printed_law_is_the_projected_cauchy_stress_of_equation_1(F):
    made = NeoHookeanAsPrinted()
    B, J = F @ F.T, np.linalg.det(F)
    sigma = made.shear_modulus / J * (B - np.eye(3)) + made.lame * (J - 1) * np.eye(3)
    normal = np.linalg.inv(F).T @ [0, 0, 1]
    P = np.eye(3) - np.outer(normal, normal) / (normal @ normal)
    second = J * np.linalg.inv(F) @ P @ sigma @ P @ np.linalg.inv(F).T
    assert numbers(made.stress(strained(F))) == pytest.approx(second[:2, :2], rel=1e-10)
    assert np.abs(second[2]).max() < 1e-6 * np.abs(second).max()  # nothing across the plane


def test_fibres_carry_tension_along_their_ply_and_less_in_compression():
    made = FibreFamilies(plies=(0.0,), modulus="200 GPa", modulus_compression="20 GPa", shear_modulus="1 kPa")
    strain = 1e-3
    for sign, modulus in ((1, 200e9), (-1, 20e9)):
        c = np.sqrt(1 + 2 * sign * strain)
        stress = numbers(made.stress(strained(np.diag([c, 1, 1]))))
        assert stress[0, 0] == pytest.approx(sign * modulus * strain, rel=6e-3)  # less than d/2 in tension
        assert abs(stress[1, 1]) < 10
        across = numbers(made.stress(strained(np.diag([1, c, 1]))))
        assert np.abs(across).max() < 10


def test_stress_and_tangent_of_a_family_go_smoothly_from_compression_to_tension():
    made = FibreFamilies(plies=(0.0,), transition=1e-4)
    strains = np.linspace(-3e-4, 3e-4, 61)
    stress = np.array([number(made.stress(strained(np.diag([np.sqrt(1 + 2 * e), 1, 1])))[0, 0]) for e in strains])
    tangent = np.gradient(stress, strains)
    assert tangent[5] == pytest.approx(24.2e9, rel=1e-3)
    assert tangent[-5] == pytest.approx(242e9, rel=1e-3)
    assert np.abs(np.diff(tangent)).max() < 0.15 * 242e9


def test_simple_shear_of_families_gives_the_shear_modulus():
    made, shear = FibreFamilies(plies=(0.0, 90.0), shear_modulus="5 MPa", transition=0.09), 1e-4
    stress = numbers(made.stress(strained([[1, shear, 0], [0, 1, 0], [0, 0, 1]])))
    assert stress[0, 1] == pytest.approx(5e6 * shear, rel=2e-2)


def test_plies_turned_with_the_deformation_give_the_same_energy():
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    c = (DEFORMATIONS[1].T @ DEFORMATIONS[1])[:2, :2]
    plies = (10.0, -35.0, 80.0)
    turned = FibreFamilies(plies=tuple(angle + np.degrees(0.4) for angle in plies))
    straight = FibreFamilies(plies=plies)
    assert in_plane_energy(turned, turn @ c @ turn.T) == pytest.approx(in_plane_energy(straight, c), rel=1e-12)
    assert in_plane_energy(straight, turn @ c @ turn.T) != pytest.approx(in_plane_energy(straight, c), rel=1e-3)


def test_a_quasi_isotropic_stack_is_isotropic_in_tension():
    made = FibreFamilies(plies=(0.0, 45.0, 90.0, -45.0), transition=1e-8)
    c = np.diag([1.02, 1.005])
    energies = []
    for angle in np.linspace(0, np.pi, 7):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        energies.append(in_plane_energy(made, turn @ c @ turn.T))
    assert energies == pytest.approx([energies[0]] * 7, rel=1e-5)
