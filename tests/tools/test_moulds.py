"""Moulds: tools upside down, and hollows."""

import pytest
from pydantic import ValidationError
from surfaces import MM, MOULDS, distance, mould, points_about, tool

from ncf_fenicsx.errors import one_line

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(("name", "kind"), [("ridge", "cylinder"), ("dome", "sphere")])
def test_a_convex_mould_is_a_tool_upside_down(name, kind):
    above = tool(kind, radius="20 mm", **({"width": "infinite"} if kind == "cylinder" else {}))
    for point in points_about(above, 20, seed=13):
        assert distance(MOULDS[name], point * [1, 1, -1]) == pytest.approx(distance(above, point), abs=1e-15)


@pytest.mark.parametrize("kind", ["cylinder", "sphere"])
def test_a_hollow_is_the_space_that_a_tool_fills(kind):
    inside = tool(kind, radius="20 mm", **({"width": "infinite"} if kind == "cylinder" else {}))
    hollow = mould(kind, radius="20 mm", shape="concave")
    for point in points_about(hollow, 20, seed=14):
        assert distance(hollow, point) == pytest.approx(-distance(inside, point), abs=1e-17)


def test_radii_of_the_moulds():
    radii = {name: made.radii for name, made in MOULDS.items()}
    one, both = (20 * MM, None), (20 * MM, 20 * MM)
    assert radii == {"ridge": one, "trough": one, "dome": both, "bowl": both, "flat": (None, None)}


@pytest.mark.parametrize(
    ("kind", "keys", "expected"),
    [
        ("cylinder", {"shape": "flat"}, "shape = 'flat': expected 'convex' or 'concave'"),
        ("sphere", {"radius": "-1 mm"}, "radius = '-1 mm': expected a positive length"),
        ("plate", {"radius": "1 mm"}, "radius = '1 mm': unknown key"),
    ],
)
def test_a_wrong_mould_is_one_line_that_names_the_key(kind, keys, expected):
    with pytest.raises(ValidationError) as caught:
        mould(kind, **keys)
    assert expected in one_line(caught.value)
