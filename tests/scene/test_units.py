import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lumpedcable.scene.units import (
    UNITS,
    UnitError,
    describe,
    format_quantity,
    nearest,
    parse_quantity,
    unit_of,
)


# The sizes are the definitions of the units: SI prefixes; the international yard and pound of 1959
# (0.3048 m/ft, 0.45359237 kg/lb); standard gravity 9.80665 m/s2; the nautical mile of 1852 m.
@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("45 kN", "N", 45_000.0),
        ("45kN", "N", 45_000.0),
        (" 4.5e1  kN ", "N", 45_000.0),
        ("1 MN", "N", 1e6),
        ("1 mN", "N", 1e-3),
        ("1 kgf", "N", 9.80665),
        ("1 tf", "N", 9806.65),
        ("1 lbf", "N", 4.4482216152605),
        ("50 mm", "m", 0.05),
        ("5 cm", "m", 0.05),
        ("2 km", "m", 2000.0),
        ("1 in", "m", 0.0254),
        ("1 ft", "m", 0.3048),
        ("1 nmi", "m", 1852.0),
        ("2 t", "kg", 2000.0),
        ("2 tonne", "kg", 2000.0),
        ("250 g", "kg", 0.25),
        ("1 lb", "kg", 0.45359237),
        ("5 ms", "s", 0.005),
        ("10 us", "s", 1e-5),
        ("10 µs", "s", 1e-5),  # micro sign
        ("10 μs", "s", 1e-5),  # Greek mu
        ("2 min", "s", 120.0),
        ("2 h", "s", 7200.0),
        ("180 deg", "rad", math.pi),
        ("180°", "rad", math.pi),
        ("50 %", "", 0.5),
        ("0.5", "", 0.5),
        ("1025 kg/m3", "kg/m3", 1025.0),
        ("1025 kg/m^3", "kg/m3", 1025.0),
        ("1025 kg/m**3", "kg/m3", 1025.0),
        ("1025 kg/m³", "kg/m3", 1025.0),
        ("1025 kg m^-3", "kg/m3", 1025.0),
        ("1025 kg·m⁻³", "kg/m3", 1025.0),
        ("1.025 g/cm3", "kg/m3", 1025.0),
        ("9.81 m/s2", "m/s2", 9.81),
        ("9.81 m/s/s", "m/s2", 9.81),
        ("9.81 N/kg", "m/s2", 9.81),
        ("10 N m2", "N m2", 10.0),
        ("10 N·m²", "N m2", 10.0),
        ("10 N*m2", "N m2", 10.0),
        ("1 kN s", "N s", 1000.0),
        ("3.6 km/h", "m/s", 1.0),
        ("1 kn", "m/s", 1852.0 / 3600.0),
        ("1 knots", "m/s", 1852.0 / 3600.0),
        ("2 kg/(m s)", "Pa s", 2.0),
        ("1 bar", "Pa", 1e5),
        ("1 kW h", "J", 3.6e6),
        ("1_000 m", "m", 1000.0),
        ("-3 m", "m", -3.0),
        (".5 m", "m", 0.5),
        ("5. m", "m", 5.0),
    ],
)
def test_quantities_are_read_into_si(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("45 m", "N", 'a length (m), "45 m"'),
        ("45 kN", "m", 'a force (N), "45 kN"'),
        ("4.5 t", "N", 'a mass (kg), "4.5 t"; did you mean "4.5 tf"?'),
        ("21.96 N/m", "kg/m", 'a force per length (N/m), "21.96 N/m"'),
        ("30 deg", "", 'an angle (rad), "30 deg"'),
        ("50 %", "N", 'a number without unit, "50 %"'),
        ("2.0 MM", "m", 'unknown unit "MM"; did you mean "mm"?'),
        ("5 tonf", "N", 'unknown unit "tonf"; did you mean "tf"?'),
        ("45 KN", "N", 'unknown unit "KN"; did you mean "kN"?'),
        ("45 Kn", "m/s", "unknown unit"),
        ("4 mmin", "s", "unknown unit"),
        ("3 metres", "m", 'unknown unit "metres"'),
        ("45", "N", '"45", which has no unit'),
        ("1 kg/m s", "N", "can be read two ways"),
        ("1 N/m*s", "N", "can be read two ways"),
        ("1,025 kg/m3", "kg/m3", "does not start with a number"),
        ("1.2.3 m", "m", "does not start with a number"),
        ("1 025 kg/m3", "kg/m3", "which is not a unit"),
        ("about 3 m", "m", "does not start with a number"),
        ("", "m", "does not start with a number"),
        ("nan m", "m", "does not start with a number"),
        ("inf m", "m", "does not start with a number"),
        ("1e400 m", "m", "not finite"),
        ("1e308 km", "m", "not finite"),
        ("1 m//s", "m/s", "which is not a unit"),
        ("1 m/", "m", "which is not a unit"),
        ("1 kg/(m s", "Pa s", "bracket that is not closed"),
        ("1 m)", "m", "which is not a unit"),
        ("1 m2 3", "m2", "which is not a unit"),
        ("1 m^0", "", "power outside 1 to 9"),
        ("1 m99", "m", "power outside 1 to 9"),
        ("1 m$", "m", "which is not a unit"),
        ("1 ((km9)9)9", "m", "a unit whose size is beyond arithmetic"),
        ("1 ((mm9)9)9", "m", "a unit whose size is beyond arithmetic"),
        ("1 1/((km9)9)9", "m", "which is not a unit"),
        ("1 m/((km9)9)9", "m", "a unit whose size is beyond arithmetic"),
        ("1 " + "km9 " * 20, "m", "a unit whose size is beyond arithmetic"),
        pytest.param("1 " + "(" * 3000 + "m" + ")" * 3000, "m", "more brackets", id="brackets"),
        pytest.param("1 m^" + "9" * 5000, "m", "power outside 1 to 9", id="power"),
        pytest.param("1 m^" + "0" * 5000 + "2", "m", "an area (m2)", id="zeros"),
    ],
)
def test_what_is_no_such_quantity_is_refused(text, unit, words):
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, unit)
    assert words in str(caught.value)


def test_case_tells_milli_from_mega():
    assert parse_quantity("1 MN", "N") == 1e9 * parse_quantity("1 mN", "N")


def test_prefixed_symbols_do_not_hide_another_unit():
    # Ends that could be read as a prefix and a unit keep the meaning of the field.
    assert describe(unit_of("min")[1]) == "a time (s)"
    assert describe(unit_of("kn")[1]) == "a speed (m/s)"
    assert describe(unit_of("kN")[1]) == "a force (N)"
    assert describe(unit_of("t")[1]) == "a mass (kg)"
    lowered = {}
    for symbol in UNITS:
        lowered.setdefault(symbol.lower(), set()).add(symbol)
    # Symbols that differ by case alone; a new one must be thought about.
    assert {frozenset(s) for s in lowered.values() if len(s) > 1} == {
        frozenset({"mN", "MN"}),
        frozenset({"kn", "kN"}),
        frozenset({"mW", "MW"}),
        frozenset({"mJ", "MJ"}),
    }


@given(
    value=st.floats(-1e30, 1e30, allow_subnormal=False),
    unit=st.sampled_from(["N", "m", "s", "kg", "kg/m3", "m/s2", "N m2", "N s", "rad", ""]),
)
def test_printed_quantities_read_back(value, unit):
    text = format_quantity(value, unit, digits=17)
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@given(a=st.sampled_from(sorted(UNITS)), b=st.sampled_from(sorted(UNITS)))
def test_products_and_quotients_multiply_sizes_and_add_exponents(a, b):
    (size_a, dim_a), (size_b, dim_b) = unit_of(a), unit_of(b)
    size, dim = unit_of(f"{a} {b}2")
    assert size == pytest.approx(size_a * size_b**2, rel=1e-15)
    assert dim == tuple(x + 2 * y for x, y in zip(dim_a, dim_b, strict=True))
    size, dim = unit_of(f"{a}/{b}")
    assert size == pytest.approx(size_a / size_b, rel=1e-15)
    assert dim == tuple(x - y for x, y in zip(dim_a, dim_b, strict=True))


@given(st.text(max_size=20))
def test_any_text_is_read_or_refused(text):
    try:
        value = parse_quantity(text, "m")
    except UnitError:
        return
    assert math.isfinite(value)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (45e3, "N", "45 kN"),
        (0.005, "s", "5 ms"),
        (1e-5, "s", "10 us"),
        (200.0, "s", "200 s"),
        (0.05, "m", "50 mm"),
        (60.0, "m", "60 m"),
        (1500.0, "m", "1.5 km"),
        (-4856.833, "N", "-4.85683 kN"),
        (999.99999999, "N", "1 kN"),
        (1025.0, "kg/m3", "1025 kg/m3"),
        (0.001, "m3", "0.001 m3"),
        (0.001, "m/s", "0.001 m/s"),
        (2000.0, "N s", "2 kN s"),
        (0.0, "N", "0 N"),
        (0.29228388, "", "0.292284"),
        (math.nan, "s", "nan s"),
    ],
)
def test_quantities_are_printed_short(value, unit, text):
    assert format_quantity(value, unit) == text


def test_unknown_dimension_is_described_by_its_si_unit():
    assert describe(unit_of("kg m/s3")[1]) == "kg m/s3"
    assert describe(unit_of("s^-4")[1]) == "1/s4"


@pytest.mark.parametrize(("text", "value"), [("−3 m", -3.0), ("2e−3 m", 2e-3), ("−.5m", -0.5)])
def test_the_sign_that_text_processors_write_is_a_minus(text, value):
    assert parse_quantity(text, "m") == value


def test_nearest_prefers_another_case_to_another_spelling():
    assert nearest("KN", ["kn2", "kN"]) == "kN"
    assert nearest("Mn", ["mN", "MN"]) == "MN"
    assert nearest("lenght", ["length", "mass"]) == "length"
    assert nearest("zzz", ["length", "mass"]) is None


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.1299, "s", "130 ms"),
        (1234.0, "m/s", "1200 m/s"),
        (999.6, "N", "1 kN"),
        (2.5e6, "", "2.5e+06"),
    ],
)
def test_few_digits_are_written_out(value, unit, text):
    assert format_quantity(value, unit, digits=2) == text
