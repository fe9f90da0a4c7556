"""Inputs are in SI, read by the scene; plans have the points that they say, the same ones each time."""

import itertools
import math

import numpy as np
import pytest
from program import DEMOS

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.sweeps import plans
from ncf_fenicsx.sweeps.inputs import Column, Input, Reader, read_inputs
from ncf_fenicsx.sweeps.ranges import parse_vary

pytestmark = pytest.mark.serial
READER = Reader(DEMOS / "long_roller.toml", ("stack.layers=2",))


def inputs(*texts):
    return read_inputs(READER, [parse_vary(text) for text in texts])


def test_values_are_in_si_and_read_back_as_the_scene_has_them():
    (one,) = inputs("laws.shear.modulus=50 kPa,1,2 MPa")
    assert one.columns == (Column("laws.shear.modulus", "Pa"),)
    assert one.columns[0].heading == "laws.shear.modulus [Pa]"
    assert one.levels == (("50000.0",), ("1000000.0",), ("2000000.0",))
    for (value,), modulus in zip(one.levels, (5e4, 1e6, 2e6), strict=True):
        scene = Scene.read(READER.file, (*READER.overrides, one.columns[0].override(value)))
        assert scene.laws.shear.modulus == modulus


def test_a_range_has_its_ends_and_is_even_or_even_in_the_logarithm():
    (even,) = inputs("tool.radius=2..5 mm:4")
    assert even.levels == (("0.002",), ("0.003",), ("0.004",), ("0.005",))
    (log,) = inputs("laws.shear.modulus=1e4..1e7 Pa:4:log")
    assert [float(value) for (value,) in log.levels] == pytest.approx([1e4, 1e5, 1e6, 1e7], rel=1e-11)
    assert float(log.at(0.5)[0]) == pytest.approx(math.sqrt(1e11), rel=1e-11)
    (whole,) = inputs("stack.divisions.0=6..9:4")
    assert whole.levels == (("6",), ("7",), ("8",), ("9",))


def test_numbers_without_unit_words_and_places_in_lists_are_inputs():
    kinds, penalty, depth, speed = inputs(
        "interface={kind='stitched'},{kind='one_sided'}",
        "tool.penalty=1,10",
        "tool.path.0.travel=['0 mm', '0 mm', '-0.1 mm'],['0 mm', '0 mm', '-0.2 mm']",
        "tool.path.0.speed=1,2 mm/min",
    )
    assert kinds.levels == (("{kind='stitched'}",), ("{kind='one_sided'}",))
    assert penalty.columns[0].unit == ""
    assert len(depth.levels) == 2
    assert speed.columns[0].heading == "tool.path.0.speed [m/s]"


def test_tied_keys_are_columns_that_change_together():
    (one,) = inputs("stack.divisions,tool.radius=([6, 1], 2 mm),([8, 1], 3 mm)")
    assert [column.heading for column in one.columns] == ["stack.divisions", "tool.radius [m]"]
    assert one.levels == (("[6, 1]", "0.002"), ("[8, 1]", "0.003"))
    assert one.name == "stack.divisions and tool.radius"


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["stack.layrs=1,2"], "layrs"),
        (["tool.radius=1,2 MPa"], "tool.0?.?radius = '1 MPa': expected a positive length"),
        (["tool.radius=1..2 MPa:3"], "expected a positive length"),
        (["tool.radius=5..2 mm:3"], "empty range; expected a lower end below the upper"),
        (["tool.radius=2..2 mm:3"], "empty range"),
        (["gravity=0..9 m/s^2:3:log"], "expected a positive lower end"),
        (["stack.divisions.0=6..8:9"], "has 3 whole numbers"),
        (["interface.kind,stack.layers=(stitched, 2),(one_sided, two)"], "stack.layers = 'two'"),
        (["tool.radius=1,2 mm", "tool.radius=3 mm"], "tool.radius: varied twice"),
        (["interface.kind=stitched,glued"], "glued"),
    ],
)
def test_what_is_no_valid_scene_is_refused(texts, expected):
    with pytest.raises(SceneError, match=expected) as caught:
        inputs(*texts)
    assert "\n" not in str(caught.value)


def test_a_grid_is_all_with_all():
    pair = inputs("laws.shear.modulus=1,2 MPa", "tool.radius=2..5 mm:4")
    plan = plans.grid(pair)
    points = list(plan.points())
    assert plan.count == len(points) == 8
    assert points == list(itertools.product(["1000000.0", "2000000.0"], ["0.002", "0.003", "0.004", "0.005"]))
    with pytest.raises(SceneError, match="a grid needs the number of values"):
        plans.grid(inputs("tool.radius=2..5 mm"))


def test_a_latin_hypercube_has_one_point_in_each_slice_and_is_the_same_each_time():
    pair = inputs("laws.shear.modulus=1e4..1e6 Pa:log", "tool.radius=2..5 mm")
    points = np.array(list(plans.latin(pair, 20, 3).points()), dtype=float)
    slices = np.floor(20 * np.log(points[:, 0] / 1e4) / np.log(100)), np.floor(20 * (points[:, 1] - 2e-3) / 3e-3)
    assert [sorted(map(int, one)) for one in slices] == [list(range(20))] * 2
    assert list(plans.latin(pair, 20, 3).points()) == list(plans.latin(pair, 20, 3).points())
    assert list(plans.latin(pair, 20, 4).points()) != list(plans.latin(pair, 20, 3).points())


def test_levels_have_even_shares_of_a_latin_hypercube():
    (one,) = inputs("laws.rate.feed=process,local")
    points = list(plans.latin([one, Input((Column("x"),), (), (0.0, 1.0))], 10, 1).points())
    assert [point[0] for point in points].count("process") == 5


def write(folder, text):
    path = folder / "points.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_list_has_units_in_its_heading_or_in_its_cells(tmp_path):
    file = write(
        tmp_path, 'tool.radius [mm],stack.divisions,laws.shear.modulus\n2,"[6, 1]",1 MPa\n\n3,"[8, 1]",20 kPa\n'
    )
    plan = plans.listed(READER, file)
    assert [column.heading for column in plan.columns] == [
        "tool.radius [m]",
        "stack.divisions",
        "laws.shear.modulus [Pa]",
    ]
    assert list(plan.points()) == [("0.002", "[6, 1]", "1000000.0"), ("0.003", "[8, 1]", "20000.0")]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is empty"),
        ("tool.radius [mm]\n", "has no rows"),
        ("tool.radius,tool.radius\n1,2\n", "expected a heading of different keys"),
        ("tool.radius [mm]\n2\n3,4\n", "line 3: 2 cells; expected 1"),
        ("tool.radius [MPa]\n2\n", "line 2: .*expected a positive length"),
        ("tool.radius\n2\n", "line 2: .*expected a positive length"),
        ("tool.radiuss [mm]\n2\n", "line 2: .*radiuss"),
    ],
)
def test_a_list_that_is_none_is_one_line(tmp_path, text, expected):
    with pytest.raises(SceneError, match=expected):
        plans.listed(READER, write(tmp_path, text))


def test_a_list_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(SceneError, match=r"--list .*: No such file"):
        plans.listed(READER, tmp_path / "none.csv")
