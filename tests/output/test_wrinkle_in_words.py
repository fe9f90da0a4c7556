"""The sentence on a run's wrinkle, and its numbers, from rows of a history."""

import json

import pytest

from ncf_fenicsx import Scene
from ncf_fenicsx.output.wrinkle_in_words import wrinkle_record

pytestmark = pytest.mark.serial

THIN = {"thickness": "0.5 mm", "areal_density": "356.25 g/m^2"}
PRESS = {"travel": ["0 mm", "0 mm", "-0.1 mm"], "speed": "1 mm/min"}
ALONG = {"travel": ["3 mm", "0 mm", "0 mm"], "speed": "20 mm/min"}


def scene(layers=2, tool=None, path=(PRESS, ALONG), **keys):
    foot = {"kind": "presser_foot", "position": ["15 mm", "0 mm"], "path": list(path)}
    table = {"stack": THIN | {"layers": layers}, "mould": {"kind": "plate"}} | keys
    return Scene.from_table(table | ({"tool": tool or foot}))


def row(time, layers=2, void=0.0, mould=0.0, x=43e-3, count=1, slope=0.4, lift=None, **heights):
    made = {"time": time, "mould_void_volume": void, "void_volume_1": 0.0}
    for name in [f"{{}}_{n + 1}" for n in range(layers)] + ["mould_{}"]:
        height = mould if name == "mould_{}" else heights.get(f"h{name[-1]}", 0.0)
        values = {"height": height, "lift": height if lift is None else lift, "length": 54.04e-3, "x": x, "y": 0.0}
        made |= {name.format(f"wrinkle_{key}"): value for key, value in (values | {"count": count}).items()}
        made |= {name.format("misalignment_max"): slope, name.format("curvature_max"): 130.0}
    return made


def test_the_sentence_names_height_length_layers_place_time_and_void():
    history = [row(0.0), row(6.0), row(12.4, h1=0.05e-3), row(15.0, h1=7.7e-3, h2=7.6e-3, mould=7.71e-3, void=210.4e-9)]
    found = wrinkle_record(scene(), history)
    assert found["wrinkle"] == (
        "a wrinkle 7.71 mm high and 54 mm long in both layers, crest 25 mm ahead of the middle of the tool; "
        "first seen at 12.4 s; void 210 mm3"
    )
    table = json.loads(json.dumps(found))["wrinkle_measures"]
    assert table["height_m"] == 7.71e-3
    assert table["layers"] == [1, 2]
    assert table["slope_deg"] == pytest.approx(22.918, rel=1e-4)
    assert table["first_seen_s"] == 12.4


@pytest.mark.parametrize(
    ("made", "words"),
    [
        ({"h1": 1e-3}, "a wrinkle 1 mm high and 54 mm long in layer 1, crest 25 mm ahead"),
        ({"h2": 1.2345, "count": 3}, "3 wrinkles, the highest 1230 mm high and 54 mm long in layer 2, "),
        ({"h3": 1e-3, "h2": 2e-3, "x": 3e-3}, "in layers 2 and 3, crest 15 mm behind the middle of the tool"),
        ({"h1": 1e-3, "h2": 1e-3, "h3": 1e-3}, "in all 3 layers"),
        ({"h1": 1e-3, "slope": 1.7}, "it overhangs: its face leans by 97 degrees and is no graph over x and y"),
    ],
)
def test_layers_places_and_overhangs_have_their_words(made, words):
    assert words in wrinkle_record(scene(3), [row(15.0, 3, **made)])["wrinkle"]


def test_the_place_without_a_way_without_a_tool_and_beside_two():
    seen = row(6.0, 1, h1=1e-3)
    assert "in the layer, crest 28 mm from the middle of the tool" in wrinkle_record(scene(1), [seen])["wrinkle"]
    pair = [{"kind": "cylinder", "position": [f"{x} mm", "0 mm"], "path": [PRESS]} for x in (10, 40)]
    assert "crest 3 mm from the middle of tool_2" in wrinkle_record(scene(1, pair), [seen])["wrinkle"]
    bare = Scene.from_table({"stack": THIN | {"layers": 1}, "duration": "1 s"})
    assert "crest at x = 43 mm, y = 0 mm" in wrinkle_record(bare, [seen])["wrinkle"]


def test_nothing_is_said_to_be_nothing_and_what_is_gone_too():
    found = wrinkle_record(scene(), [row(0.0), row(15.0, h1=0.049e-3)])
    assert found == {
        "wrinkle": "no wrinkle: no crest stands out by 0.05 mm, a tenth of a layer's thickness",
        "wrinkle_measures": None,
    }
    gone = wrinkle_record(scene(), [row(0.0), row(3.0, h1=1e-3), row(4.0, h1=1e-3), row(15.0)])["wrinkle"]
    assert gone == "no wrinkle: no crest stands out by 0.05 mm, a tenth of a layer's thickness; one did from 3 s to 4 s"
    between = wrinkle_record(scene(), [row(15.0, h1=1e-3, lift=0.0)])  # what is left between two tools
    assert between["wrinkle_measures"] is None
