"""Random valid scenes over wide ranges: each ends or stops with a reason; no crash, no silent wrong number."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_scenes import PROFILE, check, decades

pytestmark = pytest.mark.serial


CONTACTS = st.sampled_from(
    [{}, {"contact": {"kind": "augmented_lagrangian"}}, {"contact": {"kind": "nitsche", "variant": "symmetric"}}]
)
TOOLS = st.sampled_from(
    [
        {"kind": "cylinder", "width": "infinite", "radius": "4 mm"},
        {"kind": "cylinder", "width": "6 mm", "radius": "3 mm"},
        {"kind": "plate"},
        {"kind": "sphere", "radius": "5 mm"},
    ]
)


@st.composite
def tables(draw):
    """A scene of few elements; everything that may be extreme is drawn from many decades."""
    thickness, layers = draw(st.floats(0.5, 4.0)), draw(st.integers(1, 3))
    speed = draw(decades(0.01, 100, "mm/min"))
    depth = layers * thickness * draw(st.floats(0.02, 0.45))
    path = [{"travel": ["0 mm", "0 mm", f"{-depth:.6g} mm"], "speed": speed}]
    if draw(st.booleans()):
        path.append({"travel": ["0 mm", "0 mm", f"{1.5 * depth:.6g} mm"], "speed": speed})
    enforced = draw(CONTACTS)
    friction = {"friction": {"coefficient": draw(st.floats(0.05, 0.6))}} if draw(st.booleans()) else {}
    density = draw(st.floats(0.25, 0.55)) * thickness * 1790
    return {
        "stack": {
            "layers": layers,
            "thickness": f"{thickness:.6g} mm",
            "size": ["12 mm", "8 mm"],
            "divisions": draw(st.sampled_from([[6, 2], [3, 3], [8, 1]])),
            "grading": [draw(st.floats(0, 0.9)), 0],
            "areal_density": f"{density:.6g} g/m^2",
            "through": draw(st.integers(1, 2)),
        },
        "laws": {
            "in_plane": {"modulus": draw(decades(1e6, 1e12, "Pa"))},
            "shear": {"modulus": draw(decades(1e2, 1e9, "Pa"))},
            "rate": {"feed": draw(st.sampled_from(["local", "process"]))},
        },
        "interface": {"kind": draw(st.sampled_from(["one_sided", "stitched"]))} | enforced | friction,
        "tool": draw(TOOLS) | {"path": path, "penalty": float(draw(decades(0.1, 1e4, "")))} | enforced | friction,
        "solver": {"max_steps": 40, "first_step": draw(st.sampled_from(["1e9 s", None]))},
        "output": {"picture": False, "report": False, "fields_every": 1000},
    }


def cleaned(table):
    """Without a first step, or with one that is the whole of the path."""
    solver = table["solver"]
    if solver["first_step"] is None:
        del solver["first_step"]
    else:
        solver |= {"first_step": solver["first_step"], "largest_step": solver["first_step"]}
    return table


@settings(max_examples=5, **PROFILE)
@given(tables())
def test_a_few_random_scenes_end_or_say_why(table):
    check(cleaned(table))


@pytest.mark.slow
@settings(max_examples=250, **PROFILE)
@given(tables())
def test_many_random_scenes_end_or_say_why(table):
    check(cleaned(table))
