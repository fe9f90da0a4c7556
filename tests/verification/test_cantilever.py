"""A strip that hangs over an edge, against the elastica: linear and softening bending, large rotations."""

import numpy as np
import pytest
from layers import everywhere, simulate
from program import DEMOS
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.laws.bending import MomentTable

pytestmark = pytest.mark.serial

WEIGHT = 1.385 * 9.81
LINEAR = {"kind": "table", "curvature": ["2.29 1/m"], "moment": ["0.2735 N"]}
SOFTENING = {"kind": "table"}


def elastica(law, length):
    """Deflection and reach (m) of the tip of a clamped strip under its weight, from its own integral of the moment."""
    inverse = np.linspace(0, 40, 40001)
    moment = np.array(law.moment_at(inverse))

    def slopes(s, state):
        angle, carried = state[:2]  # from the tip: the moment grows by the weight beyond, at its lever
        return [-np.interp(carried, moment, inverse), WEIGHT * s * np.cos(angle), np.sin(angle), np.cos(angle)]

    def shape(tip):
        return solve_ivp(slopes, (0, length), [tip, 0, 0, 0], rtol=1e-9, atol=1e-12).y[:, -1]

    tip = brentq(lambda angle: shape(angle)[0], 0.0, 1.5)
    return shape(tip)[2:]


def hung(length, bending, folder, divisions=60, order=2):
    """The same of the program."""
    changes = [f"stack.size=['{1e3 * length} mm', '5 mm']", f"stack.divisions=[{divisions}, 1]", f"stack.order={order}"]
    table = Scene.read(DEMOS / "cantilever.toml", changes).table()
    table["laws"]["bending"] = bending
    simulation, history = simulate(table, folder)
    problem = simulation.problem
    x, u = problem.space.tabulate_dof_coordinates(), problem.displacement.x.array.reshape(-1, 3)
    end = np.isclose(x[:, 0], length)
    sunk, drawn = (everywhere(u[end, axis]).mean() for axis in (2, 0))
    carried = 4 * WEIGHT * length * 5e-3 / 2
    assert history[-1]["support_force"] == pytest.approx(carried, rel=1e-4)
    return -sunk, length + drawn


@pytest.mark.parametrize(
    ("length", "bending"),
    [
        pytest.param(0.2, LINEAR, id="linear", marks=pytest.mark.slow),  # each table is a form of its own to compile
        pytest.param(0.3, LINEAR, id="linear, far", marks=pytest.mark.slow),
        pytest.param(0.2, SOFTENING, id="softening"),
        pytest.param(0.22, SOFTENING, id="softening, beyond the knee"),
        pytest.param(0.235, SOFTENING, id="softening, far"),
    ],
)
def test_a_strip_over_an_edge_is_the_elastica(folder, length, bending):
    made = MomentTable.model_validate({name: value for name, value in bending.items() if name != "kind"})
    sunk, reach = elastica(made, length)
    ours = hung(length, bending, folder)
    assert 0.1 < sunk / length < 0.4
    assert ours == pytest.approx((sunk, reach), rel=0.01)


@pytest.mark.parametrize(("order", "divisions"), [(1, 60), (2, 20)])
def test_elements_longer_than_thick_bend_without_locking_though_fibres_are_stiff(folder, order, divisions):
    """Fibres of 242 GPa over a layer that bends with 1.43 GPa; elements 3 or 10 times as long as high."""
    sunk, reach = elastica(MomentTable.model_validate({k: v for k, v in LINEAR.items() if k != "kind"}), 0.2)
    modulus = 12 * 0.2735 / 2.29 / 1e-3**3
    bending = {"kind": "mid_plane", "modulus": f"{modulus} Pa", "poisson": 0.0}
    ours = hung(0.2, bending, folder, divisions, order)
    assert ours == pytest.approx((sunk, reach), rel=0.01)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"stack": {"sides": {"bottom": "free"}}}, "expected a fixed side with bottom = 'free'"),
        (
            {"stack": {"sides": {"bottom": "free", "x_min": "fixed"}}, "mould": {"kind": "plate"}},
            "stack.sides.bottom = 'free': expected \"plane\" with a mould",
        ),
    ],
)
def test_what_would_fall_is_refused(table, words):
    with pytest.raises(SceneError) as caught:
        Scene.from_table({"duration": "1 s"} | table)
    assert words in str(caught.value)
