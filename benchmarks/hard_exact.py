"""Exact answers of the hard cases in configs/hard/, from `lumpedcable.exact` and a few closed forms.

Nothing here comes from the engine. Numbers of the scenes are written out again, so that a change of
a scene shows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import fsolve

from lumpedcable.exact import LinearRelease, beam_frequencies, inverse_tension, release_wave

Array = NDArray[np.float64]

NYLON = (270.3e3, 10.2, -2.128, 262.7e3, 135.5)  # Zhu, Yin & Shen 2018, eq. 5: p1 ... p5
NYLON_MASS, NYLON_LENGTH = 2.238, 60.0  # kg/m, m


def nylon(e):
    """The nylon law, cut at zero (N)."""
    p1, p2, p3, p4, p5 = NYLON
    return np.maximum(p1 * np.tanh(p2 * e + p3) + p4 + p5 * e, 0.0)


def nylon_wave(pretension: float):
    """The exact wave of the nylon line that lets go at once under a pretension (N)."""
    return release_wave(nylon, NYLON_MASS, tension0=pretension)


def felt(pretension: float, length: float, ramp: float) -> float:
    """When the wall has lost 1 % of its tension (s), after a cos^2 ramp into a rarefaction.

    The wall doubles what arrives, so half a per cent must: it leaves the end when cos^2 is 0.995 and
    travels at its own speed.
    """
    e = inverse_tension(nylon, 0.995 * pretension, (0.0, 1.0))
    h = 1e-6
    speed = np.sqrt((nylon(e + h) - nylon(e - h)) / (2.0 * h) / NYLON_MASS)
    return float(ramp * 2.0 / np.pi * np.arcsin(np.sqrt(0.005)) + length / speed)


def break_at_once() -> dict[str, float]:
    wave = nylon_wave(450e3)
    front = 1e3 * wave.front_arrival(NYLON_LENGTH)
    return {"end speed, m/s": wave.end_speed, "front arrival, ms": front}


def pile_up() -> dict[str, float]:
    return {"reversed after, ms": 1e3 * pile_up_bounds()[0]}


def pile_up_bounds() -> tuple[float, float]:
    """Times (s) between which the line of pile-up.toml must have reversed: see there."""
    wave = nylon_wave(450e3)
    before = wave.front_arrival(NYLON_LENGTH)
    mass = NYLON_MASS * NYLON_LENGTH
    push = 450e3 / mass
    distance = 0.5 * NYLON_LENGTH * (1.0 + wave.strain0)
    # the push can only go on after `before`, and then fall, but not turn around
    return before, before + (distance - 0.5 * push * before**2) / (push * before)


# snap.toml: N, kg/m, m, -, m/s
SNAP = {"EA": 1e6, "mass": 1.0, "length": 50.0, "slack": 0.005, "speed": 2.5}


def snap_loads() -> dict[str, float]:
    """Tensions (N) behind the shock, where both meet and at the ends; speed (m/s) of the shock."""
    c = np.sqrt(SNAP["EA"] / SNAP["mass"])
    d, ratio = SNAP["slack"], SNAP["speed"] / c
    e1 = 0.5 * (-d + np.sqrt(d**2 + 4.0 * ratio**2))
    first = SNAP["EA"] * e1
    rise = SNAP["mass"] * c * SNAP["speed"]
    return {
        "first": first, "middle": first + rise, "ends": first + 2.0 * rise,
        "again": first + 3.0 * rise, "shock": c * np.sqrt(e1 / (e1 + d)),
    }  # fmt: skip


def snap() -> dict[str, float]:
    exact = snap_loads()
    return {
        "first load at the ends, N": exact["first"],
        "load in the middle, N": exact["middle"],
        "load at the ends, N": exact["ends"],
        "peak, N": exact["again"],
    }


STIFF = LinearRelease(20.0, 1e9, 10.0, 1e6, 5e-3)
SOFT = LinearRelease(20.0, 1e4, 1.0, 500.0, 0.1)
GRADED = LinearRelease(100.0, 1e6, 1.0, 50e3, 20e-3)


def mid_break() -> dict[str, float]:
    wave = nylon_wave(180e3)
    return {
        "left end, m/s": wave.end_speed,
        "right end, m/s": wave.end_speed,
        "left arrival, ms": 1e3 * felt(180e3, 37.5, 5e-3),
        "right arrival, ms": 1e3 * felt(180e3, 22.5, 5e-3),
    }


class Rung(NamedTuple):
    """The line of ringing.toml by characteristics: velocities (m/s) of its ends, momentum (N s)."""

    start: Array
    end: Array
    momentum: Array


def rung(time: Array) -> Rung:
    """Exact end velocities and momentum away from the wall, for a linear line of two breaks.

    With Z = sqrt(EA m), T - Z v travels towards the end, T + Z v towards the start, L/c on the way.
    Where the force F on an end is known, the wave that leaves is 2 F less the one that comes; where
    the end is fixed (v = 0), it is the one that comes.
    """
    tau, Z, pull, second, ramp = 0.1, 1e3, 50e3, 0.25, 10e-3

    def share(t):
        return float(np.cos(0.5 * np.pi * np.clip(t / ramp, 0.0, 1.0)) ** 2) if t >= 0 else 1.0

    def to_start(t):  # T + Z v that leaves the end
        return pull if t < 0.0 else 2.0 * pull * share(t) - to_end(t - tau)

    def to_end(t):  # T - Z v that leaves the start
        if t < second:
            return to_start(t - tau)
        return 2.0 * held * share(t - second) - to_start(t - tau)

    held = to_start(second - tau - 1e-12)  # what the wall carries when it begins to break

    def v_start(t):
        return 0.0 if t < second else (to_start(t - tau) - held * share(t - second)) / Z

    def v_end(t):
        return (pull * share(t) - to_end(t - tau)) / Z if t > 0.0 else 0.0

    def wall(t):
        return to_start(t - tau) if t < second else held * share(t - second)

    kinks = [0.1, 0.11, 0.25, 0.26]

    def impulse(t):
        forces = (lambda s: pull * share(s), wall)
        first, last = (
            quad(f, 0.0, t, points=[k for k in [*kinks, ramp] if k < t] or None, limit=200)[0]
            for f in forces
        )
        return first - last

    return Rung(*(np.array([f(t) for t in time]) for f in (v_start, v_end, impulse)))


def ringing() -> dict[str, float]:
    return {"momentum, N s": float(rung(np.array([0.5])).momentum[0])}


def lashing(e):
    """The law of dead-band.toml: Fritsch & Butland 1984, eq. 5, written anew (N)."""
    x = np.array([0.0, 0.02, 0.03, 0.05, 0.08])
    y = np.array([0.0, 0.0, 5e3, 20e3, 60e3])
    h, d = np.diff(x), np.diff(y) / np.diff(x)
    a = (h[:-1] + 2.0 * h[1:]) / (3.0 * (h[:-1] + h[1:]))
    bottom = a * d[1:] + (1.0 - a) * d[:-1]
    inner = np.where(d[:-1] * d[1:] > 0.0, d[:-1] * d[1:] / np.where(bottom > 0, bottom, 1.0), 0.0)
    curve = CubicHermiteSpline(x, y, [d[0], *inner, d[-1]])
    e = np.asarray(e, float)
    taut = curve(np.clip(e, x[0], x[-1])) + d[-1] * np.maximum(e - x[-1], 0.0)
    return np.where(e < x[1], 0.0, taut)


def lashing_wave():
    return release_wave(lashing, 1.0, tension0=60e3, knots=(0.02, 0.03, 0.05), bracket=(0.03, 0.1))


def dead_band() -> dict[str, float]:
    wave = lashing_wave()
    return {"end speed, m/s": wave.end_speed, "strain behind, %": 100.0 * wave.end_strain}


def single_precision() -> dict[str, float]:
    arrives = 1e3 * felt(180e3, NYLON_LENGTH, 5e-3)
    return {"end speed, m/s": nylon_wave(180e3).end_speed, "front arrival, ms": arrives}


class Stream(NamedTuple):
    """light-in-current.toml: net buoyancy, drags across and along (N/m), length (m), EA (N)."""

    lift: float
    across: float
    along: float
    length: float
    EA: float


STREAM = Stream(
    (1025.0 * np.pi * 0.05**2 / 4.0 - 1.2) * 9.81,
    0.5 * 1025.0 * 0.05 * 1.2 * 5.0**2,
    0.5 * 1025.0 * np.pi * 0.05 * 0.01 * 5.0**2,
    50.0,
    1e6,
)


def trailing() -> tuple[float, float]:
    """Angle (rad) of the free line in the stream, and the tension at its anchor (N)."""
    # b cos p = D (1 - cos^2 p) is quadratic in cos p
    r = STREAM.lift / STREAM.across
    cosine = 0.5 * (-r + np.sqrt(r**2 + 4.0))
    sine = np.sqrt(1.0 - cosine**2)
    return float(np.arccos(cosine)), STREAM.length * (STREAM.lift * sine + STREAM.along * cosine**2)


def spanning(rise: float = 40.0) -> tuple[float, float]:
    """Tensions (N) at the lower and upper anchor of the line in the stream, by shooting.

    d(T t)/ds + b z + D |n| n + Dt |w| w t = 0 with t the tangent, n and w the parts of the unit
    stream across and along the line, r' = (1 + T/EA) t; s is the unstretched length.
    """

    def slope(_, y):
        force = y[2:]
        tension = np.hypot(*force)
        t = force / tension
        w = t[0]
        n = np.array([1.0, 0.0]) - w * t
        load = STREAM.across * np.hypot(*n) * n + STREAM.along * abs(w) * w * t
        load[1] += STREAM.lift
        return np.concatenate([(1.0 + tension / STREAM.EA) * t, -load])

    def shoot(force):
        whole = solve_ivp(slope, (0.0, STREAM.length), [0.0, 0.0, *force], rtol=1e-11, atol=1e-9)
        return whole.y[:, -1]

    # swept downstream like a weightless line: D (rise/2) across and about as much along
    guess = STREAM.across * rise * np.array([0.5, 0.3])
    force = fsolve(lambda f: shoot(f)[:2] - [0.0, rise], guess, xtol=1e-12)
    return float(np.hypot(*force)), float(np.hypot(*shoot(force)[2:]))


def light_in_current() -> dict[str, float]:
    angle, anchor = trailing()
    return {
        "held, anchor, N": spanning()[0],
        "free, angle, deg": np.degrees(angle),
        "free, anchor, N": anchor,
    }


def rod_tip(time: Array, modes: int = 40) -> Array:
    """Deflection (m) of the end of the rod of stiff-bending.toml after it was let go."""
    load, length, EI, mass = 3.0, 10.0, 1e4, 1.0
    w = 2.0 * np.pi * beam_frequencies(length, EI, mass, modes, "cantilever")
    b4 = w**2 * mass * length**4 / EI
    return 4.0 * load * length**3 / EI * np.cos(np.outer(time, w)) @ (1.0 / b4)


def stiff_bending() -> dict[str, float]:
    # P L^3 / (3 EI): the series at t = 0
    return {"tip at rest, mm": 1e3 * 3.0 * 10.0**3 / (3.0 * 1e4), "tip history, % off": 0.0}
