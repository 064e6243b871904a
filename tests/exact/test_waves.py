"""The exact release wave against independent numbers, closed forms, and what defines it."""

from dataclasses import replace

import numpy as np
import pytest
from nylon_line import LENGTH, MASS, RUNS, SLACK_STRAIN, cut, cut_slope, slope, tension
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from wave_checks import (
    characteristics,
    continuity,
    energy,
    momentum,
    oleinik,
    order,
    rankine_hugoniot,
)

from lumpedcable.exact import inverse_tension, release_wave, released_strain

LAWS = {
    "signed": (tension, slope),
    "signed, no derivative": (tension, None),
    "cut at zero": (cut, cut_slope),
    "cut at zero, no derivative": (cut, None),
}


@pytest.fixture(params=LAWS, scope="module")
def law(request):
    return LAWS[request.param]


# -- the law ------------------------------------------------------------------------------------


def test_law_values():
    # Zhu 2018 parameters; the values were computed independently.
    assert tension(0.0) == pytest.approx(-42.04758014, rel=1e-9)
    assert tension(-0.05) == pytest.approx(-4856.833005, rel=1e-9)
    assert np.sqrt(slope(0.208627451) / MASS) == pytest.approx(1109.950828, rel=1e-9)
    assert np.sqrt(slope(SLACK_STRAIN) / MASS) == pytest.approx(261.4621165, rel=1e-8)


@pytest.mark.parametrize("run", RUNS, ids=lambda r: f"{r.T0 / 1e3:g}kN")
def test_inverse_tension(run):
    for law in (tension, cut):
        e0 = inverse_tension(law, run.T0)
        assert e0 == pytest.approx(run.e0, rel=1e-9)
        assert e0 == pytest.approx(brentq(lambda e: tension(e) - run.T0, 0.0, 0.5), abs=1e-12)


def test_released_strain_is_the_slack_strain():
    for law in (tension, cut):
        assert released_strain(law, 0.3) == pytest.approx(SLACK_STRAIN, rel=1e-9)


def test_released_strain_in_compression_and_at_a_corner():
    assert released_strain(lambda e: 1e6 * (e + 0.02), 0.05) == pytest.approx(-0.02, abs=1e-15)
    assert released_strain(lambda e: 1e6 * e, 0.05) == 0.0
    assert released_strain(lambda e: 1e6 * np.maximum(e - 0.01, 0.0), 0.05) == pytest.approx(0.01)


# -- against independent numbers ----------------------------------------------------------------


@pytest.mark.parametrize("run", RUNS, ids=lambda r: f"{r.T0 / 1e3:g}kN")
def test_nylon_line(law, run):
    wave = release_wave(law[0], MASS, tension0=run.T0, derivative=law[1])
    assert wave.strain0 == pytest.approx(run.e0, rel=1e-9)
    assert wave.end_strain == pytest.approx(SLACK_STRAIN, rel=1e-9)
    assert wave.end_speed == pytest.approx(run.end_speed, rel=1e-9)
    assert wave.isentropic_end_speed == pytest.approx(run.isentropic, rel=1e-9)
    assert 1e3 * wave.front_arrival(LENGTH) == pytest.approx(run.front_ms, rel=1e-9)
    assert np.sqrt(slope(wave.strain0) / MASS) == pytest.approx(run.c0, rel=1e-9)
    kinds = [p.kind for p in wave.pieces]
    if run.tangent is None:
        assert kinds == ["rarefaction"]
        assert wave.front_speed == pytest.approx(run.c0, rel=1e-9)
    else:
        assert kinds == ["shock", "rarefaction"]
        assert wave.pieces[0].strain_lo == pytest.approx(run.tangent, rel=1e-9)
        assert wave.front_speed == pytest.approx(run.shock_speed, rel=1e-9)


# -- by routes of its own -----------------------------------------------------------------------


def test_rarefaction_by_quadrature():
    for run in RUNS[:2]:
        wave = release_wave(tension, MASS, strain0=run.e0)
        by_quad = quad(lambda e: np.sqrt(slope(e) / MASS), wave.end_strain, run.e0, epsabs=0)[0]
        assert wave.end_speed == pytest.approx(by_quad, rel=1e-11)


def test_shock_and_rarefaction_by_tangency():
    for run in RUNS[2:]:
        e0 = run.e0
        foot = brentq(
            lambda e, e0=e0: slope(e) * (e0 - e) - (tension(e0) - tension(e)),
            0.05,
            0.205,
            xtol=1e-15,
        )
        sigma = np.sqrt((tension(e0) - tension(foot)) / (e0 - foot) / MASS)
        fan = quad(lambda e: np.sqrt(slope(e) / MASS), SLACK_STRAIN, foot, epsabs=0)[0]
        wave = release_wave(tension, MASS, strain0=e0)
        assert wave.pieces[0].strain_lo == pytest.approx(foot, rel=1e-10)
        assert wave.front_speed == pytest.approx(sigma, rel=1e-12)
        assert wave.end_speed == pytest.approx(sigma * (e0 - foot) + fan, rel=1e-9)


@pytest.mark.parametrize("run", RUNS, ids=lambda r: f"{r.T0 / 1e3:g}kN")
def test_conditions(law, run):
    T, derivative = law
    wave = release_wave(T, MASS, tension0=run.T0, derivative=derivative)
    assert rankine_hugoniot(T, MASS, wave.pieces) < 1e-12
    assert oleinik(T, wave.pieces) < 1e-12
    assert order(wave.pieces) < 1e-8
    assert characteristics(slope, MASS, wave) < 1e-10
    assert momentum(T, MASS, wave) < 1e-9
    assert continuity(wave) < 1e-9
    assert energy(T, MASS, wave) < 1e-9


def test_end_force_that_stays():
    wave = release_wave(tension, MASS, tension0=450e3, end_tension=100e3)
    assert tension(wave.end_strain) == pytest.approx(100e3, rel=1e-12)
    assert momentum(tension, MASS, wave) < 1e-9
    assert energy(tension, MASS, wave) < 1e-9


# -- the checkers fail on wrong answers ---------------------------------------------------------


def test_checkers_refuse_wrong_waves():
    wave = release_wave(tension, MASS, tension0=450e3)
    shock, fan = wave.pieces
    # The paper's reading: the front arrives at L/c(e0), 75 ms.
    slow = (replace(shock, speed_lo=800.45, speed_hi=800.45), fan)
    assert rankine_hugoniot(tension, MASS, slow) > 0.3
    assert order(slow) > 200.0
    # One shock all the way: right jump conditions, but it breaks the entropy condition.
    e0, e_r = wave.strain0, wave.end_strain
    sigma = np.sqrt(450e3 / (e0 - e_r) / MASS)
    single = replace(
        shock, strain_lo=e_r, speed_lo=sigma, speed_hi=sigma, velocity_lo=sigma * (e0 - e_r)
    )
    assert rankine_hugoniot(tension, MASS, (single,)) < 1e-9
    assert oleinik(tension, (single,)) > 0.05
    one_shock = replace(wave, pieces=(single,), end_speed=single.velocity_lo)
    assert energy(tension, MASS, one_shock) < 1e-9  # conservation alone does not tell
    # The isentropic speed is 0.2 % off.
    isentropic = replace(wave, end_speed=wave.isentropic_end_speed)
    assert continuity(isentropic) > 1e-3
    # A front that runs ahead leaves too much moving and too little stored.
    fast = replace(wave, pieces=(replace(shock, speed_lo=1100.0, speed_hi=1100.0), fan))
    assert momentum(tension, MASS, fast) > 1e-2
    assert energy(tension, MASS, fast) > 1e-2
    # Fans of another law.
    soft = release_wave(lambda e: 0.9 * tension(e), MASS, tension0=180e3)
    assert characteristics(slope, MASS, soft) > 0.05


# -- closed forms -------------------------------------------------------------------------------


def test_linear_law():
    # c = sqrt(EA/m), v = c e0; 50 m/s and 50 ms to mid-span (case 1 of the peers' comparison).
    for EA, mass, e0 in ((1e6, 1.0, 0.05), (3.3e8, 41.7, 1.3e-4), (7.0, 300.0, 0.8)):
        wave = release_wave(lambda e, EA=EA: EA * e, mass, strain0=e0)
        c = np.sqrt(EA / mass)
        assert [p.kind for p in wave.pieces] == ["contact"]
        assert wave.front_speed == pytest.approx(c, rel=1e-14)
        assert wave.end_speed == pytest.approx(c * e0, rel=1e-14)
        assert wave.isentropic_end_speed == pytest.approx(c * e0, rel=1e-10)
        assert wave.reflection_return(100.0) == pytest.approx(200.0 / c, rel=1e-14)
        assert wave.dissipation_rate == 0.0
    wave = release_wave(lambda e: 1e6 * e, 1.0, strain0=0.05)
    assert wave.end_speed == pytest.approx(50.0)
    assert wave.front_arrival(50.0) == pytest.approx(0.05)


def test_power_laws():
    k, mass, e0 = 4e6, 1.7, 0.2
    # T = k e^2: c = sqrt(2 k e/m), v = sqrt(2 k/m) 2/3 e0^1.5; the sound speed starts at zero.
    wave = release_wave(lambda e: k * np.maximum(e, 0.0) ** 2, mass, strain0=e0)
    assert wave.end_speed == pytest.approx(np.sqrt(2 * k / mass) * e0**1.5 / 1.5, rel=1e-9)
    xi = np.array([0.2, 0.5, 0.9]) * wave.front_speed
    assert wave.strain(xi) == pytest.approx(mass * xi**2 / (2 * k), rel=1e-9)
    w = np.sqrt(2 * k / mass) / 1.5 * (e0**1.5 - (mass * xi**2 / (2 * k)) ** 1.5)
    assert wave.velocity(xi) == pytest.approx(w, rel=1e-9)
    # T = k e^3, signed: c = sqrt(3 k/m) e.
    wave = release_wave(lambda e: k * e**3, mass, strain0=e0, derivative=lambda e: 3 * k * e**2)
    assert wave.end_speed == pytest.approx(np.sqrt(3 * k / mass) * e0**2 / 2, rel=1e-9)
    assert wave.reflection_return(10.0) > 1e4  # the released part carries next to no sound


def test_softening_law_is_one_shock():
    # T = a (1 - exp(-b e)) is concave: sigma^2 = T0/(m e0), v = sqrt(T0 e0/m).
    a, b, mass, e0 = 2e5, 8.0, 2.0, 0.15
    wave = release_wave(lambda e: a * (1 - np.exp(-b * e)), mass, strain0=e0)
    T0 = a * (1 - np.exp(-b * e0))
    assert [p.kind for p in wave.pieces] == ["shock"]
    assert wave.front_speed == pytest.approx(np.sqrt(T0 / (mass * e0)), rel=1e-13)
    assert wave.end_speed == pytest.approx(np.sqrt(T0 * e0 / mass), rel=1e-13)
    area = a * e0 - a / b * (1 - np.exp(-b * e0)) - 0.5 * T0 * e0
    assert wave.dissipation_rate == pytest.approx(wave.front_speed * area, rel=1e-10)


def test_table():
    # Slopes 100, 300, 200 N: a jump on the first segment, a shock over the two others.
    e, T, mass = [0.0, 0.1, 0.2, 0.3], [0.0, 10.0, 40.0, 60.0], 0.5
    wave = release_wave(lambda x: np.interp(x, e, T), mass, strain0=0.3, knots=e)
    assert [p.kind for p in wave.pieces] == ["shock", "contact"]
    assert [p.strain_lo for p in wave.pieces] == [0.1, 0.0]
    c = np.sqrt(np.array([250.0, 100.0]) / mass)
    assert [p.speed_hi for p in wave.pieces] == pytest.approx(c, rel=1e-13)
    assert wave.end_speed == pytest.approx(0.2 * c[0] + 0.1 * c[1], rel=1e-13)
    assert wave.strain([0.5 * (c[0] + c[1]), 0.9 * c[1]]) == pytest.approx([0.1, 0.0], abs=1e-15)


def test_table_without_knots_is_close():
    e, T, mass = [0.0, 0.0713, 0.2, 0.3], [0.0, 10.0, 40.0, 60.0], 0.5
    at = np.interp(0.3, e, T)
    exact = release_wave(lambda x: np.interp(x, e, T), mass, tension0=at, knots=e)
    blind = release_wave(lambda x: np.interp(x, e, T), mass, tension0=at)
    assert blind.end_speed == pytest.approx(exact.end_speed, rel=1e-5)
    assert blind.front_speed == pytest.approx(exact.front_speed, rel=1e-5)


def test_many_shocks():
    def wavy(e):
        return 1e5 * (e + e**2 + 0.03 * np.sin(40.0 * e))

    def wavy_slope(e):
        return 1e5 * (1.0 + 2.0 * e + 1.2 * np.cos(40.0 * e))

    # The law falls in places; the wave jumps over one dip in every 2 pi/40 of strain.
    wave = release_wave(wavy, 2.0, strain0=0.5)
    kinds = [p.kind for p in wave.pieces]
    assert kinds == [
        "shock",
        "rarefaction",
        "shock",
        "rarefaction",
        "shock",
        "rarefaction",
        "shock",
    ]
    assert np.isnan(wave.isentropic_end_speed)
    assert rankine_hugoniot(wavy, 2.0, wave.pieces) < 1e-12
    assert oleinik(wavy, wave.pieces) < 1e-12
    assert order(wave.pieces) < 1e-7
    assert characteristics(wavy_slope, 2.0, wave) < 1e-8
    assert momentum(wavy, 2.0, wave) < 1e-8
    assert continuity(wave) < 1e-8
    assert energy(wavy, 2.0, wave) < 1e-8


# -- a numerical scheme finds the same wave -----------------------------------------------------


def rusanov(law, mass, e0, c_max, n, periods):
    """First-order finite volumes on 0 < s < 1 with a force-free end at s = 0; c_max bounds c."""
    h = 1.0 / n
    dt = 0.95 * h / c_max
    e, w = np.full(n, e0), np.zeros(n)
    steps = int(periods / (c_max * dt))
    for _ in range(steps):
        T = law(e)
        mean_w, mean_T = 0.5 * (w[1:] + w[:-1]), 0.5 * (T[1:] + T[:-1])
        flux_w = mean_w + 0.5 * c_max * (e[1:] - e[:-1])
        flux_T = mean_T + 0.5 * c_max * mass * (w[1:] - w[:-1])
        # At the free end T = 0; the velocity there follows from the outgoing characteristic.
        flux_w = np.concatenate([[w[0] + T[0] / (mass * c_max)], flux_w, [0.0]])
        flux_T = np.concatenate([[0.0], flux_T, [T[-1]]])
        e = e + dt / h * np.diff(flux_w)
        w = w + dt / h * np.diff(flux_T) / mass
    return (np.arange(n) + 0.5) * h / (steps * dt), e, w


def test_finite_volumes_converge_to_it():
    wave = release_wave(tension, MASS, tension0=450e3)
    error = []
    for n in (200, 800):
        xi, e, w = rusanov(tension, MASS, wave.strain0, 1110.0, n, 0.8)
        error.append((np.mean(np.abs(e - wave.strain(xi))), np.mean(np.abs(w - wave.velocity(xi)))))
    (e1, w1), (e2, w2) = error
    assert min(e1 / e2, w1 / w2) > 2.2  # first order in L1, less in the corners of the fan
    assert e2 / wave.strain0 < 0.01
    assert w2 / wave.end_speed < 0.01
    # The isentropic reading (one long fan to c(e0)) is not what it converges to.
    xi, e, _ = rusanov(tension, MASS, wave.strain0, 1110.0, 800, 0.8)
    wrong = np.where(xi < 800.45, wave.strain(xi), wave.strain0)
    assert np.mean(np.abs(e - wrong)) / wave.strain0 > 0.05


# -- the reflection -----------------------------------------------------------------------------


@pytest.mark.parametrize("run", RUNS[1::2], ids=lambda r: f"{r.T0 / 1e3:g}kN")
def test_reflection_return_by_integrating_the_characteristic(run):
    wave = release_wave(tension, MASS, tension0=run.T0)

    def backwards(t, s):
        # A hair behind the front, where the head of the reflection starts.
        xi = np.maximum(s, 0.0) / t * (1.0 - 1e-12)
        return -np.sqrt(slope(wave.strain(xi)) / MASS)

    def home(t, s):
        return s[0]

    home.terminal = True
    start = wave.front_arrival(LENGTH)
    path = solve_ivp(backwards, (start, 1.0), [LENGTH], events=home, rtol=1e-8, atol=1e-8)
    assert wave.reflection_return(LENGTH) == pytest.approx(path.t_events[0][0], rel=1e-6)


# -- errors -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"strain0": 0.1, "mass": 0.0}, "positive mass"),
        ({"mass": 1.0}, "exactly one"),
        ({"strain0": 0.1, "tension0": 1e3, "mass": 1.0}, "exactly one"),
        ({"tension0": 1e7, "mass": 1.0}, "no strain between"),
        ({"strain0": 0.1, "end_tension": 1e6, "mass": 1.0}, "a release lowers"),
        ({"strain0": 0.0, "mass": 1.0}, "a release lowers"),
        ({"strain0": np.nan, "mass": 1.0}, "a release lowers"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        release_wave(tension, **arguments)


def test_fields_refuse_points_off_the_line():
    wave = release_wave(tension, MASS, tension0=45e3)
    with pytest.raises(ValueError, match="negative"):
        wave.strain(-1.0)
    with pytest.raises(ValueError, match="positive length"):
        wave.reflection_return(0.0)
