"""Raw files of testing machines: read right, or refused in one line that names row and column."""

import pytest
from raw_styles import FORCE, MALFORMED, STYLES, TIME, TRAVEL

from ncf_fenicsx.calibration.raw_files import read_tests
from ncf_fenicsx.errors import SceneError

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("style", STYLES)
def test_every_style_gives_the_same_numbers(tmp_path, style):
    file = tmp_path / "raw.csv"
    file.write_bytes(STYLES[style])
    tests = read_tests(file)
    assert len(tests) == (2 if style.startswith(("several", "a column")) else 1)
    for test in tests:
        assert set(test.columns) == {"time", "travel", "force"}
        assert test.columns["time"][:6] == pytest.approx(TIME, rel=1e-9)
        assert test.columns["travel"][:6] == pytest.approx([1e-3 * value for value in TRAVEL], rel=1e-9)
        assert test.columns["force"][:6] == pytest.approx(FORCE, rel=1e-9)
        assert len(test.columns["time"]) == (11 if style == "unload branch" else 6)
    if style == "preamble":
        assert tests[0].remarks["layers"] == "2"
        assert tests[0].remarks["length"] == "152 mm"


@pytest.mark.parametrize("name", MALFORMED)
def test_what_is_malformed_is_one_line(tmp_path, name):
    file = tmp_path / "raw.csv"
    text, words = MALFORMED[name]
    file.write_text(text, "utf-8")
    with pytest.raises(SceneError) as caught:
        read_tests(file)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
