"""Waves of every face and the opening over a mould, on imposed shapes: order, ranks, moulds, symmetry planes."""

import numpy as np
import pytest
from assembled import assign, build

from ncf_fenicsx.output.contact_measures import ContactMeasures

PLATE = {"kind": "plate"}
HILL = {"kind": "cylinder", "radius": "200 mm"}
HEIGHT, SPAN, CREST = 2e-3, 30e-3, 33e-3
TURN = np.pi / SPAN


def table(layers=1, order=1, sides=None, elements=120, **keys):
    stack = {"layers": layers, "size": ["60 mm", "6 mm"], "divisions": [elements, 1], "grading": [0, 0], "order": order}
    held = {"x_min": "fixed", "x_max": "free", "y_max": "symmetry"}
    return {"stack": stack | {"sides": held | (sides or {})}, "duration": "1 s"} | keys


def bump(x):
    """Smooth wave of height HEIGHT and length SPAN about CREST along x, in m."""
    return np.where(abs(x - CREST) < SPAN / 2, HEIGHT * np.cos(TURN * (x - CREST)) ** 4, 0.0)


def observed(table, shape):
    problem, _ = build(table)
    assign(problem, shape)
    problem.contacts.refresh()
    return ContactMeasures(problem).observe()


def up(x):
    return np.stack([0 * x[0], 0 * x[0], bump(x[0])])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("layers", [1, 3])
def test_every_face_has_the_same_wrinkle_where_the_layers_lift_together(order, layers):
    row = observed(table(layers, order, elements=120 // order, mould=PLATE), up)
    assert "wrinkle_height_4" not in row
    for column in [f"wrinkle_{{}}_{layer + 1}" for layer in range(layers)] + ["mould_wrinkle_{}"]:
        assert row[column.format("height")] == pytest.approx(HEIGHT, rel=1e-3)
        assert row[column.format("lift")] == pytest.approx(HEIGHT, rel=1e-3)
        assert row[column.format("x")] == pytest.approx(CREST, abs=0.05e-3)
        assert 0.8 * SPAN < row[column.format("length")] < SPAN
        assert row[column.format("count")] == 1
    assert row["mould_gap_max"] == pytest.approx(HEIGHT, rel=1e-2)
    assert row["mould_void_volume"] == pytest.approx(4 * 6e-3 * HEIGHT * SPAN * 3 / 8, rel=1e-3)
    assert 0.6 * SPAN < row["mould_void_longest"] < SPAN
    assert row["misalignment_max_1"] == pytest.approx(row[f"misalignment_max_{layers}"], rel=1e-6)


def test_without_a_mould_the_top_face_has_its_wave_over_the_plane():
    row = observed(table(1), up)
    assert row["wrinkle_height_1"] == pytest.approx(HEIGHT, rel=1e-3)
    assert not any(name.startswith("mould") for name in row)


def test_over_a_hill_a_wrinkle_is_what_lifts_off_the_hill():
    """A draped stack is no wrinkle although it is deflected by 9 mm; a wave over it has its own height and place."""
    radius, shift = 200e-3, CREST

    def drape(x, lift=0.0):
        angle = (x[0] - shift) / radius
        reach = radius + x[2] + lift
        return np.stack([shift + reach * np.sin(angle) - x[0], 0 * x[0], reach * np.cos(angle) - radius - x[2]])

    hill = HILL | {"position": [f"{shift} m", "0 mm"]}
    flat = observed(table(1, mould=hill), drape)
    assert flat["wrinkle_amplitude_1"] > 1e-3
    assert flat["wrinkle_height_1"] == flat["wrinkle_x_1"] == flat["mould_wrinkle_height"] == 0.0
    assert flat["mould_void_volume"] == pytest.approx(0.0, abs=1e-15)
    row = observed(table(1, mould=hill), lambda x: drape(x, bump(x[0])))
    assert row["wrinkle_height_1"] == pytest.approx(HEIGHT, rel=1e-3)
    assert row["mould_wrinkle_lift"] == pytest.approx(HEIGHT, rel=1e-3)
    assert row["wrinkle_x_1"] == pytest.approx(CREST, abs=0.05e-3)
    volume = 4 * 6e-3 * HEIGHT * SPAN * 3 / 8
    assert row["mould_void_volume"] == pytest.approx(volume, rel=0.01)


def test_a_strip_bent_to_a_half_circle_has_its_angle_its_curvature_and_its_place():
    """Lines are followed along their nodes: the angle is that of the arc, up to 100 degrees, where it overhangs."""
    radius, end = 10e-3, np.radians(100)

    def bent(x):
        s = np.clip(x[0] - CREST, -end * radius, end * radius)
        over = (x[0] - CREST - s) / radius
        angle, reach = s / radius, radius + x[2] - 2e-3
        along = CREST + reach * np.sin(angle) + radius * over * np.cos(angle)
        return np.stack([along - x[0], 0 * x[0], reach * np.cos(angle) - radius * over * np.sin(angle) - x[2] + 10e-3])

    row = observed(table(1, elements=240, mould=PLATE), bent)
    assert row["misalignment_max_1"] == pytest.approx(end, abs=0.02)
    assert row["curvature_max_1"] == pytest.approx(1 / radius, rel=0.01)
    assert row["wrinkle_x_1"] == pytest.approx(CREST, abs=0.02e-3)


def test_a_wave_at_a_symmetry_plane_is_whole():
    """The crest is on the plane; the half that is modelled is 15 mm long, the whole 30 mm."""
    sides = {"x_min": "symmetry"}
    half = observed(table(1, sides=sides, mould=PLATE), lambda x: up(np.stack([x[0] + CREST, x[1], x[2]])))
    assert half["wrinkle_height_1"] == pytest.approx(HEIGHT, rel=1e-3)
    assert half["wrinkle_x_1"] == pytest.approx(0.0, abs=1e-9)
    assert 0.8 * SPAN < half["wrinkle_length_1"] < SPAN
    assert half["mould_void_volume"] == pytest.approx(8 * 6e-3 * HEIGHT * SPAN * 3 / 16, rel=1e-3)
