"""Stacks that bend: cantilevers against the beam, frictionless layers against bonded ones."""

import numpy as np
import pytest
from layers import everywhere, simulate

pytestmark = pytest.mark.serial


def cantilever(layers, kind, load):
    """Strips of 10 cm a layer that neither shear nor lock: E/G (h/L)^2 / 3 and G/E (element/h)^2 are below 1 %."""
    table = {
        "gravity": "0 m/s^2",
        "laws": {
            "rate": {"kind": "none"},
            "in_plane": {"modulus": "100 GPa", "poisson": 0.0},
            "shear": {"modulus": "2 GPa"},
            "compaction": {"kind": "power", "scale": "10 GPa", "exponent": 1},
        },
        "stack": {
            "layers": layers,
            "size": [f"{100 * layers} mm", "2 mm"],
            "divisions": [75 * layers, 1],
            "grading": [0, 0],
            "sides": {"x_min": "fixed", "y_max": "symmetry"},
        },
        "interface": {"kind": kind}
        | ({} if kind == "bonded" else {"penalty": "1e9 Pa/m" if load == "roller" else "1e7 Pa/m"}),
        "mould": {"kind": "plate", "clearance": "50 mm"},
        "solver": {"first_step": "6 s", "largest_step": "6 s"},
    }
    if load == "weight":
        return table | {"gravity": "9.81 m/s^2", "duration": "12 s"}
    path = [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]
    roller = {"width": "infinite", "position": [f"{100 * layers} mm", "0 mm"], "penalty": "1e10 Pa/m", "path": path}
    return table | {"tool": roller}


def flexibility(layers, kind, load, folder):
    """Deflection of the end over the load in m/N; all layers share the load, so they bend alike."""
    return bending_of(cantilever(layers, kind, load), folder)


def bending_of(table, folder):
    """Deflection of the end of a cantilever over its load in m/N."""
    layers, load = table["stack"]["layers"], "roller" if "tool" in table else "weight"
    simulation, history = simulate(table, folder)
    problem = simulation.problem
    positions, u = problem.space.tabulate_dof_coordinates(), problem.displacement.x.array.reshape(-1, 3)
    end = np.isclose(positions[:, 0], 0.1 * layers)
    heights, sinks = everywhere(positions[end, 2]), everywhere(-u[end, 2])
    size = 2e-3
    middle = [np.abs(heights - size * (number + 0.5)) < 0.51 * size for number in range(layers)]
    by_layer = np.array([sinks[chosen].mean() for chosen in middle])
    assert np.ptp(by_layer) < 1e-2 * by_layer.mean()
    assert 1e-3 < by_layer.mean() / 2e-3 < 0.5
    assert history[-1].get("mould_contact_width", 0.0) == 0.0
    return by_layer.mean() / history[-1]["tool_force" if load == "roller" else "weight"]


@pytest.mark.parametrize(("layers", "load"), [(2, "roller"), (4, "roller"), (2, "weight"), (3, "weight")])
def test_n_frictionless_layers_have_the_nth_part_squared_of_the_bonded_stiffness(folder, layers, load):
    bonded, free = (flexibility(layers, kind, load, folder / kind) for kind in ("bonded", "one_sided"))
    assert free / bonded == pytest.approx(layers**2, rel=0.02)
    rigidity = 100e9 * 8e-3 * (2e-3 * layers) ** 3 / 12  # of the whole, four times the model's 2 mm
    exact = (0.1 * layers) ** 3 / ((8 if load == "weight" else 3) * rigidity)
    assert bonded == pytest.approx(exact, rel=0.02)


def test_a_tenth_of_the_elements_is_enough_with_order_2(folder):
    """With as many nodes, elements of order 1 lock: G / E (element / h)^2 stiffens them."""
    errors = []
    rigidity = 100e9 * 8e-3 * (2e-3) ** 3 / 12
    for order, elements in ((1, 16), (2, 8)):
        table = cantilever(1, "bonded", "roller")
        table["stack"] |= {"order": order, "divisions": [elements, 1]}
        exact = 0.1**3 / (3 * rigidity)
        errors.append(bending_of(table, folder / str(order)) / exact - 1)
    assert errors[1] == pytest.approx(0, abs=0.01)
    assert errors[0] < -0.1
