"""Finite volumes for the parted line: a second scheme, to tell whether the engine converges rightly.

With e the strain, v the velocity and T as minus the pressure the line is gas dynamics in Lagrangian
coordinates,

    e_t = v_s,    m v_t = T(e)_s - k v|v|.

MUSCL-Hancock steps (second order; B. van Leer, SIAM J. Sci. Stat. Comput. 5 (1984) 1; E. F. Toro,
Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 14.4) with the acoustic solver
between two cells at the largest speed of sound between their strains, which makes it that of
Suliciu's relaxation and with it entropic for a law with an inflection (F. Bouchut, Nonlinear Stability
of Finite Volume Methods (2004), section 2.4):

    T* = (T- + T+)/2 + m a (v+ - v-)/2,    v* = (v- + v+)/2 + (T+ - T-)/(2 m a).

A slack cell has no tension and no speed of sound of its own; `a` never falls below the speed of sound
of a line about to go slack. That is a viscosity of the size of a cell, which holds back what a start
from a jump has left too fast: the exact end is just taut, and nothing else would.

The released end takes its strain from T(e) = F(t) and its velocity from the Riemann invariant that
arrives there. Drag acts in halves before and after a step, exactly. It shares nothing with the engine:
cells where that has springs, shocks by upwinding where that has a viscosity.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from benchmarks.measures import Histories, front_time
from benchmarks.problem import Array, Line, slack_strain

COURANT = 0.9
_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(8)


def limited(before: Array, after: Array) -> Array:
    """The monotonised central slope of two differences."""
    same = before * after > 0.0
    least = np.minimum(np.abs(before), np.abs(after))
    size = np.minimum(0.5 * np.abs(before + after), 2.0 * least)
    return np.where(same, np.copysign(size, before), 0.0)


class Cells:
    """The line as `count` equal cells: means of strain and velocity, stepped in time."""

    def __init__(self, line: Line, count: int):
        self.line, self.count = line, count
        self.width = line.length / count
        start = line.strain(line.pull)
        self.strain = np.full(count, start)
        self.velocity = np.zeros(count)
        self.start, self.slack = start, slack_strain(line)
        self.fastest = line.fastest()
        # just above the slack strain, where a law that is cut still has its slope
        self.slowest = float(line.speed(self.slack + 1e-9))
        # what the end is in contact with: its strain and velocity
        self.end = (start, 0.0)
        self.wall = line.pull

    def moved(self) -> float:
        """Displacement of the released end (m)."""
        return float(np.sum(self.strain) - self.count * self.start) * self.width

    def end_strain(self, force: float) -> float:
        """The strain of the end cell's face: T(e) = F, that of the cell itself where it is slack."""
        line = self.line
        if force <= 0.0:
            return float(min(self.slack, self.strain[-1])) if line.cut else self.slack
        if force >= line.pull:
            return self.start
        return float(brentq(lambda e: float(line.tension(e)) - force, self.slack, self.start))

    def resist(self, dt: float) -> None:
        """Drag for dt (s): dv/dt = -(k/m) v|v|, exactly."""
        self.velocity /= 1.0 + self.line.drag / self.line.mass * dt * np.abs(self.velocity)

    def speed_over(self, left: Array, right: Array) -> Array:
        """The largest speed of sound (m/s) between two strains."""
        line = self.line
        a = np.maximum(line.speed(left), line.speed(right))
        over = (np.minimum(left, right) < line.inflection) & (
            np.maximum(left, right) > line.inflection
        )
        return np.maximum(np.where(over, line.speed(line.inflection), a), self.slowest)

    def step(self, t: float, dt: float) -> None:
        """From t to t + dt (s)."""
        line, ratio = self.line, dt / self.width
        self.resist(0.5 * dt)
        e, v = self.strain, self.velocity
        # a cell beyond the wall mirrors the first; at the end the face itself is known, and the
        # last cell must not reach beyond it
        ahead = self.end_strain(line.force(t)) - e[-1], self.end[1] - v[-1]
        de = np.diff(e, prepend=e[0], append=e[-1] + ahead[0])
        dv = np.diff(v, prepend=-v[0], append=v[-1] + ahead[1])
        slope_e, slope_v = limited(de[:-1], de[1:]), limited(dv[:-1], dv[1:])
        half_e = e + 0.5 * ratio * slope_v
        half_v = v + 0.5 * ratio * line.slope(e) / line.mass * slope_e
        left_e, right_e = (half_e + 0.5 * slope_e)[:-1], (half_e - 0.5 * slope_e)[1:]
        left_v, right_v = (half_v + 0.5 * slope_v)[:-1], (half_v - 0.5 * slope_v)[1:]
        left_T, right_T = line.tension(left_e), line.tension(right_e)
        a = line.mass * self.speed_over(left_e, right_e)
        T = np.empty(self.count + 1)
        w = np.empty(self.count + 1)
        T[1:-1] = 0.5 * (left_T + right_T) + 0.5 * a * (right_v - left_v)
        w[1:-1] = 0.5 * (left_v + right_v) + 0.5 * (right_T - left_T) / a
        # the wall: v = 0, the invariant v + integral of c de arrives
        first_e, first_v = half_e[0] - 0.5 * slope_e[0], half_v[0] - 0.5 * slope_v[0]
        T[0] = line.tension(first_e) + line.mass * max(line.speed(first_e), self.slowest) * first_v
        w[0] = 0.0
        # the end: T = F, the invariant v - integral of c de arrives
        last_e, last_v = half_e[-1] + 0.5 * slope_e[-1], half_v[-1] + 0.5 * slope_v[-1]
        force = line.force(t + 0.5 * dt)
        face = self.end_strain(force)
        middle, reach = 0.5 * (face + last_e), 0.5 * (last_e - face)
        T[-1] = force
        w[-1] = last_v - reach * float(_GAUSS_W @ line.speed(middle + reach * _GAUSS_X))
        self.strain = e + ratio * np.diff(w)
        self.velocity = v + ratio / line.mass * np.diff(T)
        self.end = (face, float(w[-1]))
        self.wall = max(float(T[0]), 0.0) if line.cut else float(T[0])
        self.resist(0.5 * dt)


def solve(
    line: Line, count: int, duration: float, every: float,
    progress: Callable[[float], None] | None = None,
) -> Histories:  # fmt: skip
    """The line in `count` cells for `duration` (s), kept each `every` (s)."""
    cells = Cells(line, count)
    outputs = round(duration / every)
    steps = int(np.ceil(every * cells.fastest / (COURANT * cells.width)))
    dt = every / steps
    kept, walls = [(line.pull, 0.0)], [line.pull]
    for k in range(outputs):
        speed = cells.end[1]
        for i in range(steps):
            speed = cells.end[1]
            cells.step(k * every + i * dt, dt)
            walls.append(cells.wall)
        # faces are known at mid-step: carried on by half a step
        kept.append((1.5 * walls[-1] - 0.5 * walls[-2], 1.5 * cells.end[1] - 0.5 * speed))
        if progress is not None:
            progress((k + 1) / outputs)
    tension, velocity = np.array(kept).T
    middles = np.concatenate([[0.0], (np.arange(outputs * steps) + 0.5) * dt])
    front = front_time(middles, np.array(walls))
    time = np.arange(outputs + 1) * every
    return Histories(time, tension, velocity, cells.moved(), front)
