"""The parted line by SciPy: a plain lumped chain, compiled by Numba, stepped by `solve_ivp`.

The chain is the engine's without its wave terms, written anew: half a segment's mass on either side,
T(e) cut at zero, drag on each node.
"""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.measures import COARSE, FINE, Histories, front_time
from benchmarks.peers.settings import Outcome
from benchmarks.problem import Line

SETTINGS = (("RK45", 1e-3), ("RK45", 1e-4), ("DOP853", 1e-3), ("DOP853", 1e-4))

FINE_SETTINGS = SETTINGS[::2]


@cache
def right_hand_side() -> Any:
    """dy/dt of the chain, y = (displacements, velocities) of all nodes but the fixed one.

    Compiled if Numba is there; the same without it, two hundred times slower.
    """
    try:
        from numba import njit
    except ImportError:

        def njit(function):
            return function

    @njit
    def rates(t, y, n, l, m, k, e0, F0, time, p1, p2, p3, p4, p5, cut):
        dy = np.empty_like(y)
        share = 0.0
        if t < time:
            share = np.cos(0.5 * np.pi * t / time) ** 2
        before = 0.0
        for i in range(n + 1):
            after = F0 * share
            if i < n:
                e = e0 + (y[i] - (y[i - 1] if i > 0 else 0.0)) / l
                after = p1 * np.tanh(p2 * e + p3) + p4 + p5 * e
                if cut and after < 0.0:
                    after = 0.0
            if i > 0:
                v = y[n + i - 1]
                length = l if i < n else 0.5 * l
                dy[i - 1] = v
                dy[n + i - 1] = (after - before - k * length * v * abs(v)) / (m * length)
            before = after
        return dy

    return rates


def solve(line: Line, segments: int, setting: tuple[str, float], duration: float) -> Outcome:
    """The line in `segments`, by a method of solve_ivp at a relative tolerance."""
    method, rtol = setting
    rates, e0 = right_hand_side(), line.strain(line.pull)
    arguments = (
        segments, line.length / segments, line.mass, line.drag, e0, line.pull, line.break_time,
        *line.law, line.cut,
    )  # fmt: skip

    def through(every: float):
        y = np.zeros(2 * segments)
        times = np.arange(round(duration / every) + 1) * every
        begin = time.perf_counter()
        found = solve_ivp(
            rates, (0.0, times[-1]), y, method=method, t_eval=times, args=arguments,
            rtol=rtol, atol=1e-2 * rtol,
        )  # fmt: skip
        return found, time.perf_counter() - begin

    begin = time.perf_counter()
    rates(0.0, np.zeros(2 * segments), *arguments)
    compiling = time.perf_counter() - begin
    (found, one), (_, two) = through(COARSE), through(COARSE)
    fine, _ = through(FINE)
    histories = (_histories(line, segments, e0, f) for f in (found, fine))
    status = "OK" if found.success else found.message
    return Outcome(*histories, min(one, two), compiling, int(found.nfev), "evaluations", status)


def _histories(line: Line, segments: int, e0: float, found: Any) -> Histories:
    l, u = line.length / segments, found.y[:segments]
    near = line.tension(e0 + u[0] / l)
    next_ = line.tension(e0 + (u[1] - u[0]) / l)
    tension = near + (near - next_) / 8.0  # at the wall, as the engine takes it there
    moved = float(u[-1, -1])
    return Histories(found.t, tension, found.y[-1], moved, front_time(found.t, tension))
