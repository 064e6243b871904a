"""The elastic catenary against published numbers, quadrature of its equations, and limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from wave_checks import gauss

from lumpedcable.exact import elastic_catenary

G = 9.80665


def landing(line):
    """Where the equations lead from end A to end B: x' = (1 + t/EA) H/t, z' = (1 + t/EA) V/t."""
    H, V_a = line.force_on_a
    # Panels that shrink towards the lowest point, where the tension turns fastest.
    lowest = np.clip(-V_a / line.weight, 0.0, line.length) if line.weight else 0.0
    grading = np.concatenate([[0.0], 2.0 ** -np.arange(40.0, -1.0, -1.0)])
    cuts = np.unique(
        np.concatenate([lowest * (1 - grading), lowest + (line.length - lowest) * grading])
    )

    def slope(component):
        def f(s):
            V = V_a + line.weight * s
            t = np.hypot(H, V)
            return (V if component else H) * (1.0 / t + 1.0 / line.EA)

        return f

    return [float(np.sum(gauss(slope(k), cuts[:-1], cuts[1:], 3))) for k in (0, 1)]


def miss(line):
    x, z = landing(line)
    return np.hypot(x - line.span, z - line.rise) / line.length


# -- published numbers --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("weight", "friction", "seabed", "on_a", "on_b", "bottom"),
    [
        (800.0, 5.0, 0.0, (0.0, 0.0), (-96643.435, -237751.760), 202.8103),
        (800.0, 0.1, 0.0, (80418.604, 0.0), (-96643.429, -237751.756), 202.8103),
        (200.0, 0.0, None, (43694.581, -22365.599), (-43694.581, -77634.401), 0.0),
    ],
)
def test_moorpy_cases(weight, friction, seabed, on_a, on_b, bottom):
    # The test values of MoorPy 1.3 (its catenary routine after Jonkman 2007).
    line = elastic_catenary(400, 200, 500, 7.51e12, weight, seabed=seabed, friction=friction)
    assert line.force_on_a == pytest.approx(on_a, rel=1e-6)
    assert line.force_on_b == pytest.approx(on_b, rel=1e-6)
    assert line.bottom_length == pytest.approx(bottom, abs=1e-4)


def test_chain_mooring():
    # 0.252 m chain, 390 kg/m, 410 m from the fairlead to an anchor 400 m away and 50 m below:
    # fairlead 1001.67 kN, anchor 835.59 kN on a frictionless bottom.
    weight = (390.0 - 1025.0 * np.pi / 4 * 0.252**2) * G
    line = elastic_catenary(400.0, 50.0, 410.0, 1.674e9, weight, seabed=0.0)
    assert line.tension([410.0, 0.0]) == pytest.approx([1001.67e3, 835.59e3], abs=10.0)


# -- its own equations --------------------------------------------------------------------------


def cases(count, seed=0):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        span, rise = 10 ** rng.uniform(-2, 3), rng.normal() * 10 ** rng.uniform(-2, 3)
        chord = np.hypot(span, rise)
        length = chord * (1.0 + 10 ** rng.uniform(-8, 1))
        EA, weight = 10 ** rng.uniform(4, 12), 10 ** rng.uniform(-5, 4)
        if rng.random() < 0.4:
            length, EA = chord * rng.uniform(0.6, 1.0), 10 ** rng.uniform(3, 6)
        yield span, rise, length, EA, weight


def test_lands_on_its_end():
    for span, rise, length, EA, weight in cases(150):
        line = elastic_catenary(span, rise, length, EA, weight)
        assert miss(line) < 1e-10
        x, z = line.position(length)
        assert np.hypot(x - span, z - rise) < 1e-11 * max(length, abs(rise))
        # The line carries its weight.
        down = -(line.force_on_a[1] + line.force_on_b[1])
        assert down == pytest.approx(weight * length, abs=1e-12 * float(line.tension(length)))


def test_a_wrong_force_lands_elsewhere():
    line = elastic_catenary(400, 200, 500, 1e9, 200)
    assert miss(replace(line, horizontal=1.001 * line.horizontal)) > 1e-5
    assert miss(replace(line, vertical_a=line.vertical_a + 50.0)) > 1e-5


def test_shape_by_shooting():
    line = elastic_catenary(80.0, -30.0, 120.0, 2e5, 60.0)
    H, V_a = line.force_on_a

    def along(s, _):
        t = np.hypot(H, V_a + 60.0 * s)
        return np.array([H, V_a + 60.0 * s]) * (1.0 / t + 1.0 / 2e5)

    s = np.linspace(0.0, 120.0, 13)
    path = solve_ivp(along, (0.0, 120.0), [0.0, 0.0], t_eval=s, rtol=1e-11, atol=1e-11)
    assert np.array(line.position(s)) == pytest.approx(path.y, abs=1e-8)


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0, 5.0])
def test_friction_by_integrating_from_the_fairlead(friction):
    EA, w, L = 3e6, 800.0, 500.0
    line = elastic_catenary(400.0, 200.0, L, EA, w, seabed=0.0, friction=friction)
    H, V = -line.force_on_b[0], -line.force_on_b[1]
    lift = L - V / w
    assert line.bottom_length == pytest.approx(lift, rel=1e-12)
    x = quad(lambda s: H / np.hypot(H, w * (s - lift)) + H / EA, lift, L, epsabs=1e-10)[0]
    z = quad(
        lambda s: w * (s - lift) * (1 / np.hypot(H, w * (s - lift)) + 1 / EA), lift, L, epsabs=1e-10
    )[0]
    assert z == pytest.approx(200.0, rel=1e-10)

    def pull(s):
        return max(H - friction * w * (lift - s), 0.0)

    kink = [lift - H / (friction * w)] if friction * w * lift > H else None
    bottom = lift + quad(lambda s: pull(s) / EA, 0.0, lift, points=kink, epsabs=1e-12)[0]
    assert x + bottom == pytest.approx(400.0, rel=1e-10)
    assert line.force_on_a == pytest.approx((pull(0.0), 0.0), rel=1e-9)
    # Every point of the bottom part: its own integral.
    for s in (0.3 * lift, 0.9 * lift):
        own = s + quad(lambda u: pull(u) / EA, 0.0, s, points=kink, epsabs=1e-12)[0]
        assert float(line.position(s)[0]) == pytest.approx(own, rel=1e-10)
        assert float(line.tension(s)) == pytest.approx(pull(s), rel=1e-9)


def test_random_lines_on_the_bottom():
    rng = np.random.default_rng(5)
    resting = 0
    for _ in range(150):
        span, height = 10 ** rng.uniform(0, 3), 10 ** rng.uniform(0, 2.5)
        length = np.hypot(span, height) * (1.0 + 10 ** rng.uniform(-4, 0.3))
        EA, weight, friction = 10 ** rng.uniform(5, 12), 10 ** rng.uniform(0, 4), rng.uniform(0, 2)
        line = elastic_catenary(span, height, length, EA, weight, seabed=0.0, friction=friction)
        x, z = line.position(length)
        assert np.hypot(x - span, z - height) < 1e-9 * length
        assert np.all(line.position(np.linspace(0, length, 50))[1] > -1e-9 * length)
        resting += line.bottom_length > 0.0
        if line.bottom_length == 0.0:
            assert line.force_on_a[1] >= 0.0
    assert 30 < resting < 140  # both kinds were met


# -- limits -------------------------------------------------------------------------------------


def test_inextensible_symmetric():
    # y = a cosh(x/a): L = 2 a sinh(B/(2 a)), H = w a, t_end = w a cosh(B/(2 a)).
    a, span, w = 70.0, 200.0, 35.0
    length = 2 * a * np.sinh(span / (2 * a))
    line = elastic_catenary(span, 0.0, length, np.inf, w)
    assert line.horizontal == pytest.approx(w * a, rel=1e-11)
    assert float(line.tension(0.0)) == pytest.approx(w * a * np.cosh(span / (2 * a)), rel=1e-11)
    sag = a * (np.cosh(span / (2 * a)) - 1.0)
    assert float(line.position(length / 2)[1]) == pytest.approx(-sag, rel=1e-11)


def test_taut_light_line_is_a_spring():
    line = elastic_catenary(3.0, 4.0, 4.0, 1e6, 0.0)
    assert line.force_on_a == pytest.approx((0.6 * 0.25e6, 0.8 * 0.25e6), rel=1e-14)
    assert np.array(line.position(2.0)) == pytest.approx([1.5, 2.0])
    light = elastic_catenary(3.0, 4.0, 4.0, 1e6, 1e-9)
    assert light.force_on_a == pytest.approx(line.force_on_a, rel=1e-12)


def test_vertical_lines():
    # Taut: T_top = EA (Z/L - 1) + w L/2. Slack: the fold lies where both legs end level.
    taut = elastic_catenary(0.0, 10.2, 10.0, 1e5, 30.0)
    assert -taut.force_on_b[1] == pytest.approx(1e5 * 0.02 + 150.0, rel=1e-12)
    slack = elastic_catenary(0.0, 4.0, 10.0, np.inf, 30.0)
    assert slack.force_on_a == pytest.approx((0.0, -3.0 * 30.0))
    assert slack.force_on_b == pytest.approx((0.0, -7.0 * 30.0))
    near = elastic_catenary(1e-6, 4.0, 10.0, 1e12, 30.0)
    assert near.force_on_b[1] == pytest.approx(-7.0 * 30.0, rel=1e-5)


def test_buoyant_line_is_the_mirror_image():
    down = elastic_catenary(50.0, 10.0, 70.0, 1e6, 20.0)
    up = elastic_catenary(50.0, -10.0, 70.0, 1e6, -20.0)
    s = np.linspace(0, 70, 8)
    assert up.horizontal == pytest.approx(down.horizontal, rel=1e-12)
    assert up.position(s)[1] == pytest.approx(-down.position(s)[1], abs=1e-10)


def test_ends_are_interchangeable():
    one = elastic_catenary(60.0, 25.0, 90.0, 4e5, 50.0, seabed=-5.0)
    two = elastic_catenary(60.0, -25.0, 90.0, 4e5, 50.0, seabed=-30.0)
    assert one.bottom_length > 1.0
    assert two.bottom_length == pytest.approx(one.bottom_length, rel=1e-9)
    assert two.force_on_a[0] == pytest.approx(-one.force_on_b[0], rel=1e-9)
    assert two.force_on_a[1] == pytest.approx(one.force_on_b[1], rel=1e-9)
    s = np.linspace(0.0, 90.0, 10)
    x, z = one.position(s)
    assert two.position(90.0 - s)[0] == pytest.approx(60.0 - x, abs=1e-8)
    assert two.position(90.0 - s)[1] == pytest.approx(z - 25.0, abs=1e-8)


def test_belly_on_the_bottom_is_two_anchored_halves():
    whole = elastic_catenary(160.0, 0.0, 190.0, 1e6, 40.0, seabed=-30.0)
    half = elastic_catenary(80.0, 30.0, 95.0, 1e6, 40.0, seabed=0.0)
    assert whole.horizontal > 100.0
    assert whole.horizontal == pytest.approx(half.horizontal, rel=1e-9)
    assert whole.bottom_length == pytest.approx(2 * half.bottom_length, rel=1e-9)
    s = np.linspace(0.0, 95.0, 12)
    x, z = half.position(s)
    assert whole.position(95.0 + s)[0] == pytest.approx(80.0 + x, abs=1e-8)
    assert whole.position(95.0 + s)[1] == pytest.approx(z - 30.0, abs=1e-8)


def test_deep_seabed_changes_nothing():
    free = elastic_catenary(60.0, 25.0, 90.0, 4e5, 50.0)
    assert elastic_catenary(60.0, 25.0, 90.0, 4e5, 50.0, seabed=-60.0) == free


def test_left_over_length_lies_in_a_heap():
    # 100 m of line, 30 m deep, anchor 20 m away: 30 m hang (stretched by w h^2/2 EA), no pull.
    line = elastic_catenary(20.0, 30.0, 100.0, np.inf, 10.0, seabed=0.0)
    assert line.horizontal == 0.0
    assert line.bottom_length == pytest.approx(70.0)
    assert line.force_on_b == pytest.approx((0.0, -300.0))
    x, z = line.position([50.0, 70.0, 100.0])
    assert x == pytest.approx([20.0, 20.0, 20.0])
    assert z == pytest.approx([0.0, 0.0, 30.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((10, 0, 9, np.inf, 1.0), "does not span"),
        ((10, 0, 11, 1e6, 0.0), "weightless"),
        ((-1, 0, 11, 1e6, 1.0), "span of 0 m or more"),
        ((10, 0, 0, 1e6, 1.0), "positive length"),
        ((10, 0, 11, -1e6, 1.0), "positive EA"),
    ],
)
def test_errors(arguments, message):
    with pytest.raises(ValueError, match=message):
        elastic_catenary(*arguments)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"friction": 0.5}, "needs a seabed"),
        ({"seabed": 1.0}, "lies below"),
        ({"seabed": -1.0, "friction": 0.5}, "expected seabed = 0"),
        ({"seabed": 0.0, "friction": -0.5}, "0 or more"),
    ],
)
def test_seabed_errors(more, message):
    with pytest.raises(ValueError, match=message):
        elastic_catenary(10.0, 2.0, 12.0, 1e6, 5.0, **more)


def test_other_errors():
    with pytest.raises(ValueError, match="by its weight"):
        elastic_catenary(10.0, 2.0, 12.0, 1e6, -5.0, seabed=0.0)
    with pytest.raises(ValueError, match="12 m at end B"):
        elastic_catenary(10.0, 2.0, 12.0, 1e6, 5.0).position(13.0)
