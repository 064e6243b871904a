"""A linear line by PyElastica: a straight Cosserat rod, stretched, clamped at one end, then let go.

It has neither a nonlinear law nor drag of water, so that it gets a linear line alone, and at a small
strain: its sections shrink as it is stretched, which at 5 % makes another line of it (its end then runs
at 0.976 of the speed of T = EA e).
"""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks.measures import COARSE, Histories, front_time
from benchmarks.peers.settings import Outcome
from benchmarks.problem import Line

SETTINGS = (0.9, 0.5, 0.25)
"""Steps over the time in which a wave crosses a segment."""

FINE_SETTINGS = (0.5,)

RADIUS = 0.5  # m: bending and shear do not take part


def solve(line: Line, segments: int, share: float, duration: float) -> Outcome:
    """A linear line in `segments`, after its end has let go."""
    begin = time.perf_counter()
    _through(line, segments, share, COARSE)
    compiling = time.perf_counter() - begin
    (found, one), (_, two) = (_through(line, segments, share, duration) for _ in range(2))
    steps = _steps(line, segments, share) * round(duration / COARSE)
    return Outcome(found, found, min(one, two), compiling, steps, "steps", "OK")


def _steps(line: Line, segments: int, share: float) -> int:
    return math.ceil(COARSE * line.fastest() / (share * line.length / segments))


def _through(line: Line, segments: int, share: float, duration: float) -> tuple[Histories, float]:
    import elastica

    class System(elastica.BaseSystemCollection, elastica.Constraints):
        pass

    section = math.pi * RADIUS**2
    strain = line.strain(line.pull)
    modulus = float(line.slope(strain)) / section
    rod = elastica.CosseratRod.straight_rod(
        segments, np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), line.length,
        RADIUS, line.mass / section, youngs_modulus=modulus, shear_modulus=modulus / 3.0,
    )  # fmt: skip
    rod.position_collection[0] *= 1.0 + strain
    system = System()
    system.append(rod)
    system.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    system.finalize()
    stepper, t = elastica.PositionVerlet(), 0.0
    steps = _steps(line, segments, share)
    dt = COARSE / steps
    start, kept = float(rod.position_collection[0, -1]), [(line.pull, 0.0)]
    begin = time.perf_counter()
    for _ in range(round(duration / COARSE)):
        for _ in range(steps):
            t = stepper.step(system, t, dt)
        kept.append((-float(rod.internal_stress[2, 0]), float(rod.velocity_collection[0, -1])))
    seconds = time.perf_counter() - begin
    tension, velocity = np.array(kept).T
    times = np.arange(tension.size) * COARSE
    moved = float(rod.position_collection[0, -1]) - start
    return Histories(times, tension, velocity, moved, front_time(times, tension)), seconds
