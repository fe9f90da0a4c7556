"""One number and one unit, read to the last digit, or refused with the likely meaning: nothing is half-read."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.parameters.units import parse_number, parse_quantity

pytestmark = pytest.mark.serial
THIN, NARROW, HARD = "\N{THIN SPACE}", "\N{NARROW NO-BREAK SPACE}", "\N{NO-BREAK SPACE}"

READ = [
    ("1.5 mm", "m", 1.5e-3),
    ("1.5mm", "m", 1.5e-3),
    ("  1.5 mm ", "m", 1.5e-3),
    (f"1.5{HARD}mm", "m", 1.5e-3),
    (f"1.5{THIN}mm", "m", 1.5e-3),
    ("+2 mm", "m", 2e-3),
    ("-2 mm", "m", -2e-3),
    ("−2 mm", "m", -2e-3),
    (".5 mm", "m", 5e-4),
    ("5. mm", "m", 5e-3),
    ("1e3 mm", "m", 1.0),
    ("1E-3 m", "m", 1e-3),
    ("1e−3 m", "m", 1e-3),
    ("1e3mm", "m", 1.0),
    (f"1{THIN}500 Pa", "Pa", 1500.0),
    (f"1{NARROW}500{NARROW}000 Pa", "Pa", 1.5e6),
    ("242×10^9 Pa", "Pa", 242e9),
    ("242 × 10^9 Pa", "Pa", 242e9),
    ("242×10⁹ Pa", "Pa", 242e9),
    ("3.6×10⁻⁶ m", "m", 3.6e-6),
    ("5 um", "m", 5e-6),
    ("5 µm", "m", 5e-6),
    ("5 μm", "m", 5e-6),
    ("2 Mm", "m", 2e6),
    ("0.5 mm/min", "m/s", 0.5e-3 / 60),
    ("0.5 mm / min", "m/s", 0.5e-3 / 60),
    ("1425 g/m^2", "kg/m^2", 1.425),
    ("1425 g/m**2", "kg/m^2", 1.425),
    ("1425 g/m2", "kg/m^2", 1.425),
    ("1425 g/m²", "kg/m^2", 1.425),
    ("1.79e6 g/m³", "kg/m^3", 1790.0),
    ("1 N/mm2", "Pa", 1e6),
    ("9.81 m/s2", "m/s^2", 9.81),
    ("9.81 m·s⁻²", "m/s^2", 9.81),
    ("9.81 m*s^-2", "m/s^2", 9.81),
    ("1 GPa/mm", "Pa/m", 1e12),
    ("2 h", "s", 7200.0),
]
REFUSED = [
    ("1,5 mm", "m", "1.5 mm"),
    ("0,5 mm/min", "m/s", "0.5 mm/min"),
    ("1 500 Pa", "Pa", "1500 Pa"),
    (f"1{HARD}500 Pa", "Pa", "1500 Pa"),
    ("1 000 N", "N", "1000 N"),
    ("1_5 mm", "m", "15 mm"),
    ("mm", "m", "a number before the unit"),
    *(
        (text, "m", "")
        for text in (
            "2 mm 3",
            "2*3 mm",
            "(1, 2) mm",
            "(2) mm",
            "2 (mm)",
            "1/2 mm",
            "½ mm",
            "1.2.3 mm",
            "--2 mm",
            "2 -mm",
            "2 mm;",
            "2 mm # thick",
            "2\nmm",
            "２ mm",
            "inf mm",
            "nan mm",
            "0x10 mm",
            "1e400 mm",
            "1e5e3 mm",
            "2 e3 mm",
            "2 mm mm",
            "2 mmm",
            "2 mm^2",
            "2 kg",
            "2 mm/",
            "2 /mm",
            "2 mm^",
            "2 mm^1.0",
            "2",
            "",
            "two mm",
            f"15{THIN}00 mm",
            "2 m^-1",
            "__import__('os') mm",
        )
    ),
]


@pytest.mark.parametrize(("text", "unit", "value"), READ, ids=repr)
def test_a_quantity_is_read_to_the_last_digit(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(("text", "unit", "likely"), REFUSED, ids=repr)
def test_all_else_is_refused_with_its_likely_meaning(text, unit, likely):
    assert parse_quantity(text, unit) is None
    key = {
        "m": "stack.thickness",
        "Pa": "laws.in_plane.modulus",
        "N": "tool.path.0.force",
        "m/s": "tool.path.0.speed",
    }[unit]
    path = (
        [{"hold": "1 s", "force": "1 N"}] if unit == "N" else [{"travel": ["0 mm", "0 mm", "-1 mm"], "speed": "1 m/s"}]
    )
    table = {"tool": {"path": path}, "stack": {}, "laws": {"in_plane": {}}}
    target = table
    *tables, last = key.split(".")
    for name in tables:
        target = target[int(name) if name.isdigit() else name]
    target[last] = text
    with pytest.raises(SceneError) as error:
        Scene.from_table(table)
    assert f"{key} = {text!r}" in str(error.value)
    assert likely in str(error.value)
    assert "\n" not in str(error.value)


@given(st.text("0123456789.,eE+-−_ ×^*/()xmPaNskgµ²⁻" + THIN, max_size=12))
def test_random_text_is_one_number_and_one_unit_or_refused(text):
    value = parse_quantity(text, "m")
    if value is None:
        return
    plain = text.replace("−", "-").replace(THIN, "").strip()
    number = max((plain[:end] for end in range(len(plain)) if parse_number(plain[:end]) is not None), key=len)
    unit = plain[len(number) :].strip()
    powers = {"m": 1, "mm": 1e-3, "km": 1e3, "µm": 1e-6, "am": 1e-18, "Pm": 1e15, "Em": 1e18, "pm": 1e-12}
    if "×" not in number and unit in powers:
        assert value == pytest.approx(float(number) * powers[unit], rel=1e-14)
    assert not set(text) & set(",_()x")


@given(st.integers(-(10**9), 10**9), st.integers(-12, 12))
def test_a_number_is_read_to_the_last_digit(digits, exponent):
    assert parse_number(f"{digits}e{exponent}") == float(Fraction(digits) * Fraction(10) ** exponent)


@pytest.mark.parametrize("text", ["1,2", "1_2", "1 2", "inf", "nan", "1e", "e5", "0x1", "1.5.2", "", "-", "."])
def test_what_is_no_number_is_none(text):
    assert parse_number(text) is None


@given(st.floats(1e-6, 1e6))
def test_quantities_are_converted_once_and_exactly_enough(value):
    assert parse_quantity(f"{value!r} mm", "m") == pytest.approx(value * 1e-3, rel=1e-14)
    assert parse_quantity(f"{value!r} mm/min", "m/s") == pytest.approx(value * 1e-3 / 60, rel=1e-14)


@pytest.mark.parametrize("text", ["2", "2 mm mm mm", "two mm", "", "nan m", "inf m", "2 m/", "__import__('os')", 3])
def test_what_is_no_quantity_is_none(text):
    assert parse_quantity(text, "m") is None
