"""Solids near incompressibility: closed forms of one layer of elements, and a block under a roller, do not lock.

The block is that of `demos/verification/incompressible.py`.
"""

import itertools

import numpy as np
import pytest
from assembled import assign, build
from dolfinx import fem
from linear_solids import (
    HALF_WIDTH,
    MODULUS,
    RATIOS,
    STRIP,
    TUBES,
    Linear,
    strip,
    strip_in_closed_form,
    tube,
    tube_in_closed_form,
)
from program import DEMOS, script

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.output.measures import Measures

pytestmark = pytest.mark.serial

KINDS = ("logarithmic", "split")
block = script(DEMOS / "verification" / "incompressible.py").block


@pytest.mark.parametrize(("order", "counts"), TUBES)
@pytest.mark.parametrize("poisson", RATIOS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_thick_tube_grows_by_its_closed_form(kind, poisson, order, counts):
    assert tube(kind, poisson, order, counts) == pytest.approx(tube_in_closed_form(poisson), rel=0.01)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("poisson", RATIOS)
def test_a_bonded_strip_has_the_stiffness_of_gent_and_lindley(poisson, order):
    computed = strip("split", poisson, order, HALF_WIDTH, STRIP)
    assert computed == pytest.approx(strip_in_closed_form(poisson, HALF_WIDTH), rel=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_full_integration_locks(kind):
    """What the tests above would find without the reduced rule."""
    assert tube(kind, 0.4999, 1, [24, 24, 1], "full") < 0.9 * tube_in_closed_form(0.4999)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_only_rigid_motions_of_an_element_are_free(kind, order):
    linear = Linear(kind, 0.4999, order, [1, 1, 1], [1.0, 0.8, 0.5])
    matrix = fem.assemble_matrix(fem.form(linear.stiffness)).to_dense()
    values = np.linalg.eigvalsh(matrix)
    assert np.all(np.abs(values[:6]) < 1e-9 * values[-1])
    assert values[6] > 1e-3 * MODULUS * 0.5


FINE = {0.499: 1.9453, 0.4999: 1.9477}
"""Force in N, extrapolated from 40 x 12 and 80 x 24 elements by the square of their size: docs/verification.md."""


@pytest.mark.parametrize("poisson", FINE)
def test_a_roller_on_rubber_takes_the_force_of_refinement(poisson, folder):
    result = run(Scene.from_table(block(poisson, 20, 6)), folder)
    assert result.done, result.reason
    assert result.history[-1]["tool_force"] == pytest.approx(FINE[poisson], rel=0.01)


def test_a_plate_on_a_block_whose_sides_are_free_takes_the_uniaxial_force(folder):
    """Homogeneous, so that any rule is exact: the moduli are those of the energies."""
    for kind, poisson in itertools.product(KINDS, RATIOS):
        table = block(poisson, 4, 2, kind=kind)
        table["tool"] = {"kind": "plate", "path": table["tool"]["path"]}
        table["stack"]["sides"] = {"y_max": "free"}
        result = run(Scene.from_table(table), folder, overwrite=True)
        assert result.done, result.reason
        force = result.history[-1]["tool_force"] / (4 * 20e-6)
        stretch = 1 - result.history[-1]["tool_displacement"] / 8e-3
        assert force == pytest.approx(uniaxial(kind, poisson, stretch), rel=2e-3), (kind, poisson)


def test_stress_of_cells_is_that_which_does_the_work(table):
    """A cell bent to a wedge, its volume kept: at its points J differs from 1 by some per cent, or tens of MPa."""
    largest = {}
    for rule in ("reduced", "full"):
        problem, _ = build(table | block(0.4999, 1, 1, volume_integration=rule))
        assign(problem, lambda x: np.stack([0.1 * x[0] * (x[2] - 4e-3) / 8e-3, 0 * x[0], 0 * x[0]]))
        measures = Measures(problem)
        measures.observe(np.zeros(3 * problem.contacts.body.spaces.owned), 0.0)
        largest[rule] = np.abs(measures.cells["stress_33"]).max()
    assert largest["reduced"] < 0.1e6
    assert largest["full"] > 0.2e6


def uniaxial(kind, poisson, stretch):
    """Force over undeformed area in Pa of a bar, its sides free: by hand from the energies of docs/laws.md."""
    mu, bulk = 1e6 / (2 * (1 + poisson)), 1e6 / (3 * (1 - 2 * poisson))
    lame = bulk - 2 * mu / 3

    def stresses(side):
        volume = stretch * side**2
        if kind == "logarithmic":
            both = (-mu + lame * np.log(volume)) * np.ones(2)
            return (mu * np.array([stretch**2, side**2]) + both) / np.array([stretch, side])
        squares = np.array([stretch**2, side**2])
        shape = mu * volume ** (-2 / 3) * (squares - (stretch**2 + 2 * side**2) / 3)
        return (shape + bulk * (volume - 1) * volume) / np.array([stretch, side])

    low, high = 0.9, 1.2
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if stresses(middle)[1] < 0 else (low, middle)
    return -stresses(low)[0]


def test_what_does_not_hold_is_refused_or_named():
    for poisson in (0.49991, 0.5):
        with pytest.raises(SceneError, match=r"laws\.solid\.poisson.*0\.4999"):
            Scene.from_table(block(poisson, 4, 2))
    nitsche = block(0.49, 4, 2)
    nitsche["tool"]["contact"] = {"kind": "nitsche"}
    with pytest.raises(SceneError, match=r"laws\.solid\.poisson.*Nitsche"):
        Scene.from_table(nitsche)
    cautions = Scene.from_table(block(0.49, 4, 2, volume_integration="full")).cautions
    assert any("lock" in words for words in cautions)
    assert not Scene.from_table(block(0.3, 4, 2, volume_integration="full")).cautions
    assert not Scene.from_table(block(0.4999, 4, 2)).cautions
