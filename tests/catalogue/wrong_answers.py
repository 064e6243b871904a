"""Wrong answers of the catalogue's cases, each by a mistake that somebody may make."""

import numpy as np
from mode_cases import (
    CHAIN_W,
    EA,
    EI,
    SWING,
    K,
    bar_wave,
    beam_wave,
    bouncing,
    chain_shape,
    damped_wave,
)
from motion_cases import STRETCHED, SWUNG, G, shaken, sinking
from nylon_line import MASS, RUNS
from release_cases import from_end, linear, relaxing


def soft_string(seen):
    return SWING * np.sin(K * seen.s) * np.cos(K * np.sqrt(5e4) * seen.time)[:, None]


def small_swing(seen):
    a = SWUNG * np.cos(np.sqrt(G / STRETCHED) * seen.time)
    return STRETCHED * np.stack([np.sin(a), 1.0 - np.cos(a)], axis=-1)[:, None]


def by_sound_speed(seen):
    """Run 4 with its front at the speed of sound ahead of it, as the paper has it."""
    gone = from_end(seen)[:-1] < RUNS[3].c0 * seen.time[:, None]
    return np.where(gone, 0.0, 450e3)


# mistakes that somebody may make
WRONG = {
    "standing axial wave": lambda seen: bar_wave(seen, 1.02 * EA),
    "damped axial mode": lambda seen: damped_wave(seen, 1e-9),
    "body on a heavy line": lambda seen: bouncing(seen, 1.02 * EA),
    "body on one segment": lambda seen: -SWING * np.cos(np.sqrt(1e5 / 20.0) * seen.time)[:, None],
    "taut string": soft_string,  # the mass not thinned by the stretch
    "hanging chain": lambda seen: (
        SWING * chain_shape(seen.s) * np.cos(1.02 * CHAIN_W * seen.time)[:, None]
    ),
    "cantilever": lambda seen: beam_wave(seen, 1.05 * EI),
    "pendulum": small_swing,
    "free fall": lambda seen: -0.5 * 9.7 * seen.time**2,
    "sinking": lambda seen: sinking(seen, 1.01 * 1.2),
    "shaken end": lambda seen: -np.asarray(shaken(seen)),
    "linear release, at once": lambda seen: linear(seen, 0.0, 75e3),
    "linear release, ramped": lambda seen: linear(seen, 0.0),
    "line that relaxes": lambda seen: relaxing(seen, time=0.03),
    "rarefaction": lambda seen: np.where(  # Hooke's line of the same sound speed
        from_end(seen) < RUNS[0].c0 * seen.time[:, None], 45e3 / MASS / RUNS[0].c0, 0.0
    ),
    "plateau": lambda seen: np.array([45e3 / MASS / RUNS[0].c0]),
    "shock": by_sound_speed,
}
