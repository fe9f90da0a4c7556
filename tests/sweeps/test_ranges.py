"""Texts of what is varied: each form is read as the manual says, all else is one line."""

import pytest

from ncf_fenicsx import SceneError
from ncf_fenicsx.sweeps.ranges import parse_vary, split

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a.b=0.5,1,2 MPa", ["0.5 MPa", "1 MPa", "2 MPa"]),
        ("a.b=500 kPa, 2 MPa", ["500 kPa", "2 MPa"]),
        ("a.b=1,10,100", ["1", "10", "100"]),
        ("a.b=stitched,bonded", ["stitched", "bonded"]),
        ("a=[40, 24],[80, 48]", ["[40, 24]", "[80, 48]"]),
        ("a={kind = 'x, y', of = 1},{kind = 'z'}", ["{kind = 'x, y', of = 1}", "{kind = 'z'}"]),
        ("fabric=../a.toml,../b.toml", ["../a.toml", "../b.toml"]),
        ("a.b=3 mm", ["3 mm"]),
    ],
)
def test_lists(text, values):
    vary = parse_vary(text)
    assert vary.values == tuple((value,) for value in values)
    assert vary.ends is None


@pytest.mark.parametrize(
    ("text", "ends", "count", "logarithmic"),
    [
        ("a=2..5 mm:4", ("2 mm", "5 mm"), 4, False),
        ("a=500 kPa..2 MPa", ("500 kPa", "2 MPa"), None, False),
        ("a=1e4..1e7 Pa:4:log", ("1e4 Pa", "1e7 Pa"), 4, True),
        ("a=1e4..1e7 Pa:log", ("1e4 Pa", "1e7 Pa"), None, True),
        ("a=-.5..1.5", ("-.5", "1.5"), None, False),
        ("a=2..5:4", ("2", "5"), 4, False),
    ],
)
def test_ranges(text, ends, count, logarithmic):
    vary = parse_vary(text)
    assert (vary.ends, vary.count, vary.logarithmic, vary.values) == (ends, count, logarithmic, ())


def test_tied_keys_share_a_value_or_have_one_each():
    assert parse_vary("a,b=1,2 mm").values == (("1 mm", "1 mm"), ("2 mm", "2 mm"))
    assert parse_vary("a,b=(2 mm, [1, 2]),(3 mm, [3, 4])").values == (("2 mm", "[1, 2]"), ("3 mm", "[3, 4]"))
    assert parse_vary("a, b = 1..2 mm:3").keys == ("a", "b")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a", "expected KEY=VALUES"),
        ("a=", "expected KEY=VALUES"),
        ("=1", "expected KEY=VALUES"),
        ("a,a=1", "expected each key once"),
        ("a=1,,2", "expected a value on each side of a comma"),
        ("a=1,1", "expected each value once"),
        ("a=2..mm", "expected LOW..HIGH UNIT:NUMBER"),
        ("a=2..5 mm:1", "expected a whole number of at least 2"),
        ("a=2..5 mm:x", "expected a whole number of at least 2"),
        ("a=2..5 mm:4:5", "expected LOW..HIGH UNIT:NUMBER"),
        ("a,b=(1,2,3)", "expected 2 values, one for each key"),
    ],
)
def test_all_else_is_one_line(text, expected):
    with pytest.raises(SceneError, match=expected) as caught:
        parse_vary(text)
    assert "\n" not in str(caught.value)


def test_commas_in_brackets_and_quotes_do_not_split():
    assert split("a, (b, c), '[d,', e") == ["a", "(b, c)", "'[d,'", "e"]
