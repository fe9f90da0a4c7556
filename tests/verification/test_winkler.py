"""The Winkler limit: without transverse shear each column of the fabric is pressed alone, and pressure is the law's.

The limit needs more than G_t -> 0. The stress of a layer acts along its own normal, which turns with the roller; that
alone raises the pressure under it by the factor 1 + h / (3 R) (h: thickness of the stack). So layers here are thin
against the radius. The fibres stay stiff against the pressure, by which they keep columns from sliding out sideways;
they do not carry it, as nothing but shear would bend the planes of one layer together.
"""

import numpy as np
import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene
from ncf_fenicsx.scene.stack import Stack
from ncf_fenicsx.simulation import Simulation

pytestmark = pytest.mark.serial

COMM = MPI.COMM_WORLD
PEAK, FORCE = 0.01, 0.005
"""Largest relative errors of the peak pressure and of the total force."""
THIN = {"thickness": 0.02, "radius": 225.0, "depth": 0.005}
"""In mm: contact as narrow as that of the paper's roller, 1.5 mm to either side, in a layer that is thin against R."""
WIDE = {"thickness": 2.0, "radius": 200.0, "depth": 0.5}
"""In mm: a layer of the paper's thickness under a flat roller, in contact 14 mm to either side."""


def roller(thickness, radius, depth, stack, steps=3):
    """One layer of Vf0 = 0.398 without weight, rate or shear, under a roller without ends (lengths in mm)."""
    step = f"{60 * depth / steps} s"
    return Scene.from_table(
        {
            "gravity": "0 m/s^2",
            "laws": {"in_plane": {"modulus": "1 GPa"}, "shear": {"modulus": "1 Pa"}, "rate": {"kind": "none"}},
            "stack": {
                "layers": 1,
                "thickness": f"{thickness} mm",
                "areal_density": f"{712.5 * thickness} g/m^2",
                "sides": {"y_max": "symmetry"},
                **stack,
            },
            "tool": {
                "radius": f"{radius} mm",
                "width": "infinite",
                "penalty": 100.0,
                "contact": {"kind": "augmented_lagrangian", "tolerance": 1e-6},
                "path": [{"travel": ["0 mm", "0 mm", f"{-depth} mm"], "speed": "1 mm/min"}],
            },
            "solver": {"first_step": step, "largest_step": step},
            "output": {"picture": False, "report": False, "fields_every": 100},
        }
    )


def winkler_pressure(scene, depth, x):
    """Pressure in Pa of columns at x (m) under a roller whose tip is a depth (m) below the undeformed top."""
    radius, thickness = scene.tool[0].radius, scene.stack.thickness
    pressed = np.maximum(depth - (radius - np.sqrt(radius**2 - x**2)), 0.0)
    vf0 = scene.stack.initial_volume_fraction
    return scene.laws.compaction.pressure(vf0 * thickness / (thickness - pressed), vf0)


def winkler(scene, depth):
    """Half width of the contact in m, peak pressure in Pa and force in N/m at a depth (m)."""
    radius = scene.tool[0].radius
    half_width = np.sqrt(radius**2 - (radius - depth) ** 2)
    points, weights = np.polynomial.legendre.leggauss(60)
    pressure = winkler_pressure(scene, depth, half_width * points)
    return half_width, float(winkler_pressure(scene, depth, np.zeros(1))[0]), half_width * float(weights @ pressure)


def errors(scene, row):
    """Relative errors of a row's force and peak pressure."""
    _, peak, force = winkler(scene, row["tool_displacement"])
    sides = scene.stack.sides.copies / 2  # x_min mirrors the roller, all other planes lengthen it
    length = sides * scene.stack.size[1]
    return row["tool_force"] / (length * force) - 1, row["pressure_max"] / peak - 1


def check(scene, folder):
    """Peak and force within their bounds, and the whole profile within that of the peak."""
    simulation = Simulation(scene, folder, COMM, overwrite=False)
    result = simulation.run()
    assert result.done, result.reason
    last = result.history[-1]
    force, peak = errors(scene, last)
    assert abs(peak) < PEAK
    assert abs(force) < FORCE
    half_width, highest, _ = winkler(scene, last["tool_displacement"])
    x = simulation.problem.space.tabulate_dof_coordinates()[:, 0]
    pressure = simulation.measures.contacts.nodes["contact_pressure"]
    under = (x < 0.8 * half_width) & (pressure > 0)
    difference = pressure - winkler_pressure(scene, last["tool_displacement"], x)
    assert np.abs(difference[under]).max(initial=0.0) < PEAK * highest
    assert COMM.allreduce(int(under.sum())) >= 10


def test_a_wide_contact_on_the_default_mesh_along_x_is_the_law_of_each_column(folder):
    along_x = Stack().divisions[0]
    check(roller(**WIDE, stack={"divisions": [along_x, 1]}), folder)


def test_a_contact_as_narrow_as_the_roller_s_on_the_default_mesh(folder):
    check(roller(**THIN, stack={}), folder)


def test_a_contact_as_narrow_as_the_roller_s_on_a_mesh_that_resolves_it(folder):
    check(roller(**THIN, stack={"divisions": [120, 1], "grading": [0.95, 0.0]}), folder)


def test_force_and_peak_converge_with_the_square_of_the_element(folder):
    """Over six depths, where the contact ends at another place of an element each time."""
    lengths, force, peak = [], [], []
    for divisions in (20, 40, 80, 160):
        stack = {"size": ["4 mm", "4 mm"], "divisions": [divisions, 1], "grading": [0.0, 0.0]}
        scene = roller(**THIN, stack=stack, steps=8)
        result = Simulation(scene, folder / str(divisions), COMM, overwrite=False).run()
        assert result.done, result.reason
        assert [row["step_cuts"] for row in result.history] == [0] * 9
        found = np.array([errors(scene, row) for row in result.history[3:]])
        lengths.append(4 / divisions)
        force.append(np.sqrt(np.mean(found[:, 0] ** 2)))
        peak.append(np.sqrt(np.mean(found[:, 1] ** 2)))
    rates = [np.polyfit(np.log(lengths), np.log(error), 1)[0] for error in (force, peak)]
    assert rates == pytest.approx([2.0, 2.0], abs=0.25)
    assert force[-1] < 5e-4
    assert peak[-1] < 5e-4
