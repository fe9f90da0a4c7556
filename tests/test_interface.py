"""Paired contact alone: energy, force, stiffness."""

import numpy as np
import pytest

from ncf_fenicsx.interface import PairedContact

PAIRS = np.array([[0, 2], [1, 3]], dtype=np.int32)
NORMAL = np.array([[0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])
AREA = np.array([2e-6, 3e-6])
CONTACT = PairedContact(PAIRS, np.array([[0.0, 0, 1e-4], [0, 0, 0]]), penalty=1e9, stitching=1e5)


def energy(u):
    gap = CONTACT.gap(u, NORMAL)
    return float((AREA * np.where(gap <= 0, 1e9, 1e5) * gap**2 / 2).sum())


def scattered(blocks):
    forces = np.zeros((4, 3))
    np.add.at(forces, PAIRS, blocks)
    return forces


@pytest.mark.parametrize("lift", [-3e-4, 3e-4])
def test_force_and_stiffness_are_derivatives_of_the_energy(lift):
    u = np.random.default_rng(1).normal(scale=1e-5, size=(4, 3))
    u[2:, 2] += lift
    step = 1e-9
    forces = scattered(CONTACT.residual(u, NORMAL, AREA))
    tangent = CONTACT.tangent(u, NORMAL, AREA)
    for node, axis in np.ndindex(4, 3):
        v = np.zeros((4, 3))
        v[node, axis] = step
        assert forces[node, axis] == pytest.approx((energy(u + v) - energy(u - v)) / (2 * step), rel=1e-6, abs=1e-9)
        change = scattered(CONTACT.residual(u + v, NORMAL, AREA)) - scattered(CONTACT.residual(u - v, NORMAL, AREA))
        applied = np.einsum("pij,pj->pi", tangent, v[PAIRS].reshape(2, 6)).reshape(2, 2, 3)
        assert scattered(applied) == pytest.approx(change / 2, rel=1e-6, abs=1e-12)


def test_slip_along_an_inclined_face_opens_no_gap():
    u = np.zeros((4, 3))
    before = CONTACT.gap(u, NORMAL)
    u[2] = 1e-3 * np.array([0.8, 0.0, -0.6])
    assert CONTACT.gap(u, NORMAL) == pytest.approx(before, abs=1e-15)
