"""The highline: inextensible catenaries with and without cargo, against the paper and its equations."""

import numpy as np
import pytest
from highline_numbers import (
    DROP,
    EXACT_80_KN,
    EXACT_LONG,
    EXACT_SHORT,
    FROM_80_KN,
    FROM_LENGTH,
    FROM_SAG,
    LOAD,
    LOWERED,
    PLACES,
    SPAN,
    STRAIGHT_80_KN,
    STRAIGHT_LONG,
    STRAIGHT_SHORT,
    TABLE_1,
    WEIGHT,
)
from scipy.integrate import quad

from lumpedcable.exact import (
    dragged_from_length,
    dragged_from_tension,
    elastic_catenary,
    highline_from_length,
    highline_from_sag,
    highline_from_tension,
    least_tension,
    loaded_from_length,
    loaded_from_tension,
    straight_from_length,
    straight_from_tension,
)
from lumpedcable.exact.roots import bracketed, derivatives, widened

LINE = (SPAN, DROP, WEIGHT)
PLACED = np.array(PLACES)


def unloaded(line):
    return (*line.numbers().values(), line.beta, line.alpha)


def loaded(line, with_length=False):
    S, f, F_TA, F_TB, F_H = line.numbers().values()
    found = (-line.middle[1], f, F_H, F_TA, F_TB, *([S] if with_length else []))
    return np.array(found).T


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (highline_from_sag(*LINE, 5.620999), FROM_SAG),
        (highline_from_length(*LINE, 63.34896), FROM_LENGTH),
        (highline_from_tension(*LINE, 80e3), FROM_80_KN),
    ],
)
def test_a_line_under_its_own_weight(line, expected):
    assert unloaded(line) == pytest.approx(expected, rel=1e-9)


def test_the_printed_table():
    for known, solve, value in (
        ("sag", highline_from_sag, 5.620999),
        ("length", highline_from_length, 63.34896),
    ):
        S, f, F_TA, F_TB, _ = solve(*LINE, value).numbers().values()
        printed = TABLE_1[known]
        # to half a unit of the last printed digit; f belongs to S only to its seven digits
        assert pytest.approx(printed[0], abs=0.5e-5) == S
        assert f == pytest.approx(printed[1], abs=0.5e-5)
        assert pytest.approx(printed[2], abs=1e-3) == F_TA
        assert pytest.approx(printed[3], abs=1e-3) == F_TB
        assert solve(*LINE, value).beta == pytest.approx(printed[4], rel=2e-6)
    # the paper prints 79360.08 N, what its bisection left over: exactly q c lies between the ends
    assert float(highline_from_tension(*LINE, 80e3).tension_b) == pytest.approx(80e3 - 640.0)


def test_the_receiving_end_goes_down_its_post():
    lines = highline_from_tension(SPAN, DROP + np.array(list(LOWERED)), WEIGHT, 80e3)
    assert pytest.approx(np.array(list(LOWERED.values())), rel=1e-9) == np.array(unloaded(lines)).T


def test_cargo_at_constant_length():
    for length, expected in ((63.34896, EXACT_LONG), (62.5, EXACT_SHORT)):
        lines = loaded_from_length(*LINE, LOAD, PLACED, length)
        assert loaded(lines) == pytest.approx(np.array(expected), rel=1e-9)
        assert lines.length == pytest.approx(length, rel=1e-14)


def test_cargo_at_constant_tension():
    lines = loaded_from_tension(*LINE, LOAD, PLACED, 80e3)
    assert loaded(lines, True) == pytest.approx(np.array(EXACT_80_KN), rel=1e-9)


def test_straight_segments_and_how_wrong_they_are():
    short = straight_from_length(SPAN, DROP, LOAD, PLACED, 62.5)
    assert loaded(short) == pytest.approx(np.array(STRAIGHT_SHORT), rel=1e-9)
    long = straight_from_length(SPAN, DROP, LOAD, PLACED, 63.34896)
    assert loaded(long) == pytest.approx(np.array(STRAIGHT_LONG), rel=1e-9)
    taut = straight_from_tension(SPAN, DROP, LOAD, PLACED, 80e3)
    assert loaded(taut, True) == pytest.approx(np.array(STRAIGHT_80_KN), rel=1e-9)
    error = short.tension_a / loaded_from_length(*LINE, LOAD, PLACED, 62.5).tension_a - 1.0
    assert np.all((error < -0.06) & (error > -0.071))
    # it is a light line's limit, and first order in its weight
    weights = np.array([1e-2, 1e-3])[:, None]
    light = loaded_from_length(SPAN, DROP, weights, LOAD, PLACED, 62.5)
    far = np.abs(short.tension_a / light.tension_a - 1.0)
    assert far[0] / far[1] == pytest.approx(np.full(5, 10.0), rel=1e-2)


def test_straight_segments_up_to_a_higher_end():
    # B over A bears a share of what hangs on A: the pull at A is least where it is at right angles to
    # the chord, up/sqrt(1 + (c/l)^2), and F_TA is there by eq. (24) on either side
    l, c, x, G = 40.0, -20.0, 5.0, 20e3
    H, up = np.geomspace(10.0, 1e5, 200_001), G * (1.0 - x / l)
    pull = np.hypot(up + H * c / l, H)
    assert np.min(pull) == pytest.approx(up / np.sqrt(1.25), rel=1e-6)
    for F in (1.0001 * up / np.sqrt(1.25), 17e3, up, 18e3, 1e5):
        line = straight_from_tension(l, c, G, x, F)
        assert line.tension_a == pytest.approx(F, rel=1e-12)
        taut = H[np.flatnonzero(pull <= F)[-1]]
        assert line.horizontal == pytest.approx(taut, rel=1e-3)
    with pytest.raises(ValueError, match=r"over 15652\.5 N, the least that holds the load"):
        straight_from_tension(l, c, G, x, 15.6e3)


def test_tensions_between_the_ends():
    line = loaded_from_length(*LINE, LOAD, 20.0, 62.5)
    x, z = line.middle
    # the tension of a line with weight alone follows its height, T - q z; the load jumps
    left, right = line.tension(np.linspace(0.0, 19.99, 5)), line.tension(np.linspace(20.0, 60.0, 5))
    low = line.height(np.linspace(0.0, 19.99, 5)), line.height(np.linspace(20.0, 60.0, 5))
    assert left - WEIGHT * low[0] == pytest.approx(np.full(5, line.tension_a), rel=1e-13)
    assert right - WEIGHT * low[1] == pytest.approx(
        np.full(5, line.tension_b + WEIGHT * DROP), rel=1e-13
    )
    # all that hangs is held by the ends
    up = np.sqrt(line.tension_a**2 - line.horizontal**2)
    down = np.sqrt(line.tension_b**2 - line.horizontal**2)
    assert line.parts[1].end_angle > 0.0  # it still falls where it reaches B
    assert up - down == pytest.approx(LOAD + WEIGHT * 62.5, rel=1e-12)
    assert (float(x), float(z)) == (20.0, pytest.approx(-8.826731275, rel=1e-9))
    # and the length is that of the curve
    along = [quad(lambda s, p=part: p.tension_at(s) / p.horizontal, part.x, part.x + part.reach)[0]
             for part in line.parts]  # fmt: skip
    assert sum(along) == pytest.approx(62.5, rel=1e-12)


def test_a_load_of_nothing_changes_nothing():
    plain = highline_from_length(*LINE, 63.34896)
    for line in (
        loaded_from_length(*LINE, 0.0, 20.0, 63.34896),
        dragged_from_length(*LINE, 20.0, WEIGHT, 43.34896),
    ):
        assert line.tension_a == pytest.approx(plain.tension_a, rel=1e-9)
        assert line.height(41.0) == pytest.approx(plain.height(41.0), rel=1e-9)


def test_inextensible_limit_of_the_elastic_catenary():
    for EA, far in ((1e12, 1e-6), (1e14, 1e-8)):
        elastic = elastic_catenary(SPAN, -DROP, 63.34896, EA, WEIGHT)
        assert elastic.horizontal == pytest.approx(FROM_LENGTH[4], rel=far)


@pytest.mark.parametrize("load", [0.0, 200.0])
def test_a_line_dragged_across(load):
    paid_out = 1.0 * np.array([0.0, 10.0, 30.0, 60.0])  # S = v t
    line = dragged_from_tension(*LINE, paid_out, 5.0, 4e3, load)
    assert line.parts[0].length == pytest.approx(paid_out, abs=1e-12)
    assert line.tension_b == pytest.approx(np.full(4, 4e3), rel=1e-13)
    x, z = line.middle
    assert line.parts[1].height(60.0) == pytest.approx(np.full(4, -16.0), rel=1e-12)
    pulls = line.horizontal * (np.sinh(line.parts[0].end_angle) - np.sinh(line.parts[1].angle))
    assert pulls == pytest.approx(np.full(4, load), abs=1e-9 * 4e3)
    again = dragged_from_length(*LINE, paid_out, 5.0, line.parts[1].length, load)
    assert again.tension_b == pytest.approx(line.tension_b, rel=1e-10)
    assert np.array(again.middle) == pytest.approx(np.array([x, z]), rel=1e-10, abs=1e-10)
    # nothing paid out: the traction cable alone, and a joint at A
    assert (float(x[0]), float(z[0])) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_heavy_traction_cable():
    # the long slack of both hangs deep
    line = dragged_from_length(105.0, -6.0, 10.0, 101.0, 32.0, 78.0)
    assert [float(part.length) for part in line.parts] == pytest.approx([101.0, 78.0], rel=1e-12)
    assert sum(float(part.reach) for part in line.parts) == pytest.approx(105.0, rel=1e-12)
    assert sum(float(part.drop) for part in line.parts) == pytest.approx(-6.0, rel=1e-10)
    assert all(part.reach > 0.0 for part in line.parts)
    first, second = line.parts
    assert float(first.end_angle) == pytest.approx(float(second.angle), rel=1e-12)  # no load there
    moved = dragged_from_length(105.0, -6.0, 10.0, 101.0, 32.0, 78.0 + 1e-30j)
    more, less = (
        dragged_from_length(105.0, -6.0, 10.0, 101.0, 32.0, 78.0 + d) for d in (1e-4, -1e-4)
    )
    rate = (more.tension_b - less.tension_b) / 2e-4
    assert np.imag(moved.tension_b) / 1e-30 == pytest.approx(rate, rel=1e-6)


def where_it_ends(l, c, q, s, p, load, H, slope):
    """The end under B and the tension there, by the paper's equations: H and the slope at A given."""
    a, at_joint = np.arcsinh(slope), slope - q * s / H
    x = H / q * (a - np.arcsinh(at_joint))
    down = H / q * (np.hypot(1.0, slope) - np.hypot(1.0, at_joint))
    b = np.arcsinh(at_joint - load / H)
    end = b - p * (l - x) / H
    return down + H / p * (np.cosh(b) - np.cosh(end)) - c, H * np.cosh(end), x


@pytest.mark.parametrize(
    ("numbers", "tension", "load", "H", "x"),
    [
        # H and the joint by a root search from 800 places in (log H, slope); the taut one of them
        ((50.0, 0.0, 50.0, 75.0, 2.0), 2700.0, 2500.0, 695.15, 32.84),
        ((40.0, 30.0, 50.0, 55.0, 40.0), 4900.0, 4850.0, 1706.38, 36.14),
        ((72.0, -17.0, 38.0, 105.0, 4.0), 2200.0, 2300.0, 661.22, 30.246),
        ((27.0, -2.5, 67.0, 37.0, 8.0), 3500.0, 3000.0, 624.2, 21.823),
    ],
)
def test_a_loaded_joint_under_a_heavy_line(numbers, tension, load, H, x):
    """One H has up to three lines that end at B: the one found is what was asked for."""
    line = dragged_from_tension(*numbers, tension, load)
    slope = np.sinh(line.parts[0].angle)
    off, pull, joint = where_it_ends(*numbers, load, line.horizontal, slope)
    assert (off, pull) == pytest.approx((0.0, tension), rel=1e-9, abs=1e-8)
    assert (float(line.horizontal), float(joint)) == pytest.approx((H, x), rel=2e-5)
    # with numbers that carry derivatives, and by the length of the traction cable
    slow = dragged_from_tension(*numbers, tension + 1e-30j, load)
    assert np.real(slow.horizontal) == pytest.approx(line.horizontal, rel=1e-9)
    again = dragged_from_length(*numbers, line.parts[1].length, load)
    assert again.horizontal == pytest.approx(line.horizontal, rel=1e-9)
    # among others in an array
    several = dragged_from_tension(*numbers, np.array([tension, 1.001 * tension]), load)
    assert several.tension_b == pytest.approx(np.array([tension, 1.001 * tension]), rel=1e-9)


def test_a_dragged_line_is_what_was_asked_for():
    draw = np.random.default_rng(1)
    found = 0
    for _ in range(70):
        l, c, q, p = draw.uniform((20, -20, 5, 1), (100, 30, 100, 40))
        load, s, F = (
            draw.uniform(0, 5e3),
            draw.uniform(0.8, 1.5) * l,
            10.0 ** draw.uniform(3.2, 3.8),
        )
        try:
            line = dragged_from_tension(l, c, q, s, p, F, load)
        except ValueError:
            continue
        found += 1
        off, pull, x = where_it_ends(
            l, c, q, s, p, load, line.horizontal, np.sinh(line.parts[0].angle)
        )
        assert (off, pull) == pytest.approx((0.0, F), rel=1e-8, abs=1e-7)
        assert x < l
    assert found > 15


def test_two_ways_to_a_line_agree():
    """Both unknowns at once, and one root inside another, as numbers with derivatives have it."""
    draw = np.random.default_rng(1)
    l, x = draw.uniform(20.0, 120.0, 20), draw.uniform(0.02, 0.98, 20)
    c, q, G = draw.uniform(-20.0, 20.0, 20), 10.0 ** draw.uniform(0.5, 2.5, 20), 20e3
    S = np.hypot(l, c) * (1.0 + 10.0 ** draw.uniform(-4.0, 0.0, 20))
    p, F = 10.0 ** draw.uniform(0.0, 2.0, 20), 3.0 * (G + 100.0 * q)
    for find, numbers in (
        (loaded_from_length, (l, c, q, G, x * l, S)),
        (loaded_from_tension, (l, c, q, G, x * l, F)),
        (dragged_from_tension, (l, c, q, 0.9 * x * l, p, 30.0 * (p + q) * l)),
    ):
        quick, slow = find(*numbers), find(*numbers[:-1], numbers[-1] + 0j)
        for symbol, value in quick.numbers().items():
            assert value == pytest.approx(np.real(slow.numbers()[symbol]), rel=1e-10), symbol


def test_the_least_tension():
    beta, least = least_tension(*LINE)
    assert beta == pytest.approx(1.2156, abs=0.5e-4)
    assert least == pytest.approx(2170.67, abs=0.5e-2)
    near = 0.5 * WEIGHT * SPAN / (beta * np.array([0.999, 1.001]))  # H on either side
    for H in near:
        b = 0.5 * WEIGHT * SPAN / H
        assert H * np.cosh(np.arcsinh(DROP / SPAN * b / np.sinh(b)) + b) > least
    # the paper's bracket, beta < 1, ends at 2218.77 N; the lines below it are found
    line = highline_from_tension(*LINE, np.array([2171.0, 2218.77]))
    assert line.tension_a == pytest.approx(np.array([2171.0, 2218.77]), rel=1e-12)
    assert line.beta[1] == pytest.approx(1.0, abs=1e-4)
    assert 1.0 < line.beta[0] < beta


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: highline_from_tension(*LINE, 2170.6), "2170.67 N or more.*found 2170.6 N"),
        (lambda: highline_from_length(*LINE, [70.0, 62.0]), "62.0967 m, found 62 m"),
        (lambda: highline_from_sag(*LINE, 0.0), "positive sag f, found 0 m"),
        (lambda: highline_from_sag(*LINE, np.nan), "positive sag f, found nan m"),
        (lambda: highline_from_sag(-60.0, 16.0, 40.0, 1.0), "positive span l, found -60 m"),
        (lambda: highline_from_length(60.0, np.inf, 40.0, 70.0), "finite drop c"),
        (lambda: loaded_from_length(*LINE, LOAD, 60.0, 62.5), "cargo on the span.*found 60 m"),
        (lambda: loaded_from_length(*LINE, -1.0, 30.0, 62.5), "load G of 0 N or more"),
        (lambda: loaded_from_length(*LINE, LOAD, 30.0, 62.0), "62.0967 m, found 62 m"),
        (lambda: loaded_from_length(*LINE, LOAD, 30.0, 7e3), "6209.67 m or less, found 7000 m"),
        (lambda: loaded_from_tension(*LINE, LOAD, 30.0, 15e3), "15323.4 N or more"),
        (lambda: straight_from_tension(SPAN, DROP, LOAD, 30.0, 9e3), "over 10000 N"),
        (lambda: straight_from_length(SPAN, DROP, LOAD, 30.0, 62.0), "found 62 m"),
        (lambda: dragged_from_tension(*LINE, 80.0, 5.0, 4e3), "ends before B"),
        (lambda: dragged_from_tension(*LINE, 30.0, 5.0, 100.0), "of the traction cable of"),
        (lambda: dragged_from_length(*LINE, 30.0, 5.0, 30.0), "62.0967 m, found 60 m"),
    ],
)  # fmt: skip
def test_where_there_is_no_line_the_message_says_why(call, words):
    with pytest.raises(ValueError, match=words):
        call()


SOLVED = [
    (highline_from_sag, {"sag": 5.6}),
    (highline_from_length, {"length": 63.3}),
    (highline_from_tension, {"tension": 80e3}),
    (loaded_from_length, {"load": LOAD, "place": 20.0, "length": 62.5}),
    (loaded_from_tension, {"load": LOAD, "place": 20.0, "tension": 80e3}),
    (dragged_from_tension, {"length": 30.0, "traction_weight": 5.0, "tension": 4e3}),
    (dragged_from_length, {"length": 30.0, "traction_weight": 5.0, "traction_length": 33.0}),
]


@pytest.mark.parametrize(("solve", "known"), SOLVED, ids=lambda x: getattr(x, "__name__", ""))
def test_derivatives(solve, known):
    numbers = {"span": SPAN, "drop": DROP, "weight": WEIGHT, **known}

    def outputs(**given):
        return np.array(list(solve(**given).numbers().values()))

    for name, slopes in derivatives(outputs, **numbers).items():
        change = 1e-5 * numbers[name]
        ahead, behind = (
            outputs(**{**numbers, name: numbers[name] + side * change}) for side in (1, -1)
        )
        difference = (ahead - behind) / (2.0 * change)
        # what a difference of numbers of this size can tell
        noise = 1e-13 * np.abs(outputs(**numbers)) / change
        assert slopes == pytest.approx(difference, rel=3e-6, abs=float(max(noise)))


def test_any_line_is_found():
    draw = np.random.default_rng(7)
    n = 200
    l = 10.0 ** draw.uniform(0.0, 3.0, n)
    c, q = l * draw.uniform(-2.0, 2.0, n), 10.0 ** draw.uniform(-1.0, 3.0, n)
    G = q * l * 10.0 ** draw.uniform(-3.0, 3.0, n)
    x = l * draw.uniform(0.001, 0.999, n)
    S = np.hypot(l, c) * (1.0 + 10.0 ** draw.uniform(-8.0, 1.0, n))
    line = loaded_from_length(l, c, q, G, x, S)
    assert line.length == pytest.approx(S, rel=1e-12)
    assert line.height(l) == pytest.approx(-c, rel=1e-9, abs=1e-9 * float(max(S)))
    taut = loaded_from_tension(l, c, q, G, x, line.tension_a)
    assert taut.tension_a == pytest.approx(line.tension_a, rel=1e-11)
    # of the two lines with this tension the shorter one
    assert np.all(taut.length <= S * (1.0 + 1e-9))
    plain = highline_from_length(l, c, q, S)
    assert plain.length == pytest.approx(S, rel=1e-11)
    assert highline_from_sag(l, c, q, plain.sag).horizontal == pytest.approx(
        plain.horizontal, rel=1e-9
    )


def test_roots():
    three = np.array([2.0, 9.0, 1e8])
    assert bracketed(lambda x: x**2 - three, 0.0, 1e9) == pytest.approx(np.sqrt(three), rel=1e-15)
    # flat, then steep: Newton's step alone would leave or creep
    assert bracketed(lambda x: np.sinh(x) - 1e100, 0.0, 700.0) == pytest.approx(np.arcsinh(1e100))
    slopes = derivatives(lambda a: bracketed(lambda x: x**3 - a, 0.0, 10.0), a=8.0)
    assert slopes["a"] == pytest.approx(1.0 / 12.0, rel=1e-14)
    low, high = widened(lambda x: x - three, 5.0, 1.0)
    assert np.all((low <= three) & (three <= high))
    assert np.isnan(widened(lambda x: np.tanh(x) - 2.0, 0.0, 1.0, tries=20)[0])
