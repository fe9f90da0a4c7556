"""Lines of surfaces: circles, folds and loops whose angles and crossings are known."""

import numpy as np
import pytest

from ncf_fenicsx.output.face_lines import crossing, line_families, sharpest, steepest

pytestmark = pytest.mark.serial


def surface(shape, rows=3):
    """Lines along x of a shape x(s), z(s) that is the same along y, and the plan of its nodes."""
    s = np.linspace(0, 1, 61)
    x, z = shape(s)
    y = np.linspace(0, 0.1, rows)
    plan = np.array([[one, other] for other in y for one in s])
    return plan, np.array([[a, other, b] for other in y for a, b in zip(x, z, strict=True)])


def both(function, shape):
    found = [function(*family) for family in line_families(*surface(shape))]
    return [place for place in found if place is not None]


def arc(angle):
    return lambda s: (np.sin(angle * s) / angle, (1 - np.cos(angle * s)) / angle)


def test_an_arc_turns_evenly_and_is_steepest_at_its_end():
    along, across = both(sharpest, arc(1.2))
    assert along.angle == pytest.approx(1.2 / 60, rel=1e-9)
    assert across.angle == pytest.approx(0, abs=1e-12)
    assert along.length == pytest.approx(1 / 60, rel=1e-3)
    end, _ = both(steepest, arc(1.2))
    assert end.angle == pytest.approx(1.2 * 119 / 120, rel=1e-9)
    assert end.position[[0, 2]] == pytest.approx(np.array(arc(1.2)(np.array(119 / 120))), rel=1e-3)


def test_a_kink_is_found_where_it_is():
    kink = lambda s: (s, np.maximum(0, s - 0.5))  # noqa: E731
    along, _ = both(sharpest, kink)
    assert along.angle == pytest.approx(np.pi / 4)
    assert along.position == pytest.approx([0.5, 0.0, 0.0])


@pytest.mark.parametrize(("angle", "crosses"), [(3.0, False), (6.0, False), (7.5, True)])
def test_an_arc_crosses_itself_once_it_is_more_than_a_circle(angle, crosses):
    found = both(crossing, arc(angle))
    assert bool(found) == crosses
    if crosses:
        assert found[0][[0, 2]] == pytest.approx([0, 0], abs=0.2 / angle)


def test_a_surface_off_its_grid_has_no_lines_there():
    plan, current = surface(arc(1.2))
    current[10] = np.nan
    lines, axis = line_families(plan, current)[0]
    assert steepest(lines, axis).angle == pytest.approx(1.2 * 119 / 120, rel=1e-9)
