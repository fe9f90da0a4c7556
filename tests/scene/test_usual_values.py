"""A value with a valid unit that no stack has is a caution, in the unit that one would speak of it in."""

import pytest

from ncf_fenicsx import Scene

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"thickness": "2 Mm", "areal_density": "1e-3 kg/m^2"}, "stack.thickness: 2e+09 mm is far outside"),
        ({"thickness": "0.5 um", "areal_density": "0.5 g/m^2"}, "stack.thickness: 0.0005 mm is far outside"),
        ({"size": ["76 km", "76 mm"]}, "stack.size.0: 7.6e+07 mm is far outside"),
        ({"thickness": "50 mm", "areal_density": "10 kg/m^2"}, ""),
    ],
)
def test_an_unusual_length_is_shown_in_millimetres(keys, words):
    cautions = Scene.from_table({"duration": "1 s", "stack": keys}).cautions
    assert any(caution.startswith(words) for caution in cautions) if words else not cautions


def test_values_of_laws_and_tools_are_looked_at_too():
    scene = Scene.from_table(
        {
            "laws": {"in_plane": {"modulus": "242 TPa"}},
            "tool": {"path": [{"travel": ["0 mm", "0 mm", "-1 mm"], "speed": "1 km/s"}]},
        }
    )
    assert [caution.partition(":")[0] for caution in scene.cautions] == ["laws.in_plane.modulus", "tool.0.path.0.speed"]
    assert "2.42e+05 GPa" in scene.cautions[0]
