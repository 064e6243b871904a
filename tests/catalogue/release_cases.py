"""Cases of lines that part: linear, stiffening, with a shock."""

import numpy as np
from case import Case
from engine_runs import HOOKE, ROPE
from mode_cases import outputs
from nylon_line import LENGTH, MASS, cut, tension
from player import Seen

from lumpedcable.exact import LinearRelease, RelaxingRelease, ramped_release, release_wave

# the viscosity lags by half a step, which is first order in the step and shrinks with the mesh;
# what is smooth is second order
LAGGING = (0.8, 2.5)
SPAN = 100.0  # m of HOOKE: 1 MN, 1 kg/m, 50 kN


def timed(text: str, duration: float) -> str:
    return text.partition("[output]")[0] + outputs(duration)


def towards_wall(seen: Seen):
    return -seen.velocity[..., 0]


def from_end(seen: Seen):
    """Unstretched distance of nodes from the broken end (m)."""
    return seen.s[-1] - seen.s


def slope_at(closed_form, p: float):
    """d/dp of a closed form of a number p, by central differences over 0.2 %."""
    h = 1e-3 * p
    return (closed_form(p + h) - closed_form(p - h)) / (2.0 * h)


# --- Hooke's line ---------------------------------------------------------------------------------


def linear(seen: Seen, ramp: float, pretension: float = 50e3):
    wave = LinearRelease(SPAN, 1e6, 1.0, pretension, ramp)
    return wave.velocity(np.maximum(from_end(seen), 0.0), seen.time[:, None])


AT_ONCE = Case(
    text=timed(HOOKE, 0.096),
    seen=towards_wall,
    exact=lambda seen: linear(seen, 0.0),
    scale=50.0,
    mean=True,
    # a chain's front after x = L is (l^2 L/8)^(1/3) wide (Airy), its ripples a few times that
    bound=lambda n: 2.0 * (8.0 * n**2) ** (-1.0 / 3.0),
    segments=25,
    source="Graff, Wave Motion in Elastic Solids (1975), chapter 2",
    order=(0.4, 1.1),  # 2/3 for that width, 1 for a front of fixed width in segments
    step_order=None,  # a jump has no order in the step
    gradients={"lines.rope.end.held.pretension": lambda seen: linear(seen, 0.0) / 50e3},
)
RAMP = 0.03  # s: 30 m
RAMPED = Case(
    text=timed(HOOKE, 0.096).replace("time = 0", f"time = {RAMP}"),
    seen=towards_wall,
    exact=lambda seen: linear(seen, RAMP),
    scale=50.0,
    mean=True,
    # phase (k l)^2/24 k L of k = pi/30 m, half the height, on the third of the line that is in it
    bound=lambda n: np.pi**3 / 24.0 * (SPAN / 30.0) ** 2 / n**2 * 0.5,
    segments=25,
    source="Graff (1975), chapter 2: images",
    order=(1.5, 2.7),
    step_order=LAGGING,
    gradients={
        "lines.rope.end.held.pretension": lambda seen: linear(seen, RAMP) / 50e3,
        "events.break.time": lambda seen: (
            (linear(seen, RAMP + 1e-6) - linear(seen, RAMP - 1e-6)) / 2e-6
        ),
    },
)

# --- a line that relaxes --------------------------------------------------------------------------

BRANCH = {"EA": 1e6, "time": 0.02}  # N, s: as stiff again for fast loads


def relaxing(seen: Seen, **branch: float):
    own = BRANCH | branch
    wave = RelaxingRelease(SPAN, 1e6, 1.0, 50e3, ((own["EA"], own["time"]),), RAMP)
    return wave.velocity(np.maximum(from_end(seen), 0.0), seen.time[:, None])


RELAXING = Case(
    text=RAMPED.text.replace(
        "[lines.rope]", "[materials.hooke.relaxation.fast]\nEA = 1e6\ntime = 0.02\n[lines.rope]"
    ),
    seen=towards_wall,
    exact=relaxing,
    scale=50.0,
    mean=True,
    bound=RAMPED.bound,  # its waves are longer than those of the slow stiffness
    segments=25,
    source="natural modes; Christensen, Theory of Viscoelasticity (1982)",
    order=(1.5, 2.7),
    step_order=LAGGING,
    gradients={
        f"materials.hooke.relaxation.fast.{key}": lambda seen, key=key: slope_at(
            lambda x: relaxing(seen, **{key: x}), BRANCH[key]
        )
        for key in BRANCH
    },
)

# --- the nylon line -------------------------------------------------------------------------------

PULLED = "lines.rope.end.held.pretension"


def rarefied(seen: Seen, pretension: float = 45e3):
    wave = ramped_release(tension, MASS, 20e-3, tension0=pretension)
    return wave.velocity(np.maximum(from_end(seen), 0.0), seen.time[:, None])


RAREFACTION = Case(
    text=timed(ROPE, 0.08).replace('time = "5 ms"', 'time = "20 ms"'),
    seen=towards_wall,
    exact=rarefied,
    scale=43.17,
    mean=True,
    # as above with k = pi/(c ramp), c = 658 m/s at the front and less behind it: twice for that
    bound=lambda n: np.pi**3 / 24.0 * (LENGTH / 13.2) ** 2 / n**2 * 0.5,
    segments=40,
    source="simple wave; Whitham, Linear and Nonlinear Waves (1974), chapter 6",
    order=(1.5, 2.7),
    step_order=LAGGING,
    gradients={PULLED: lambda seen: slope_at(lambda T0: rarefied(seen, T0), 45e3)},
)
C0 = 657.8555771  # m/s at 45 kN, nylon_line.RUNS
PLATEAU = Case(
    text=RAREFACTION.text,
    seen=lambda seen: towards_wall(seen)[7:, -1].mean()[None],
    exact=lambda seen: np.array([43.17086886]),
    scale=43.17086886,
    bound=RAREFACTION.bound,
    segments=40,
    source="w = integral of c de, Courant & Friedrichs (1948)",
    order=None,
    step_order=None,
    # dw/dT0 = c/T' = 1/(m c)
    gradients={PULLED: lambda seen: np.array([1.0 / (MASS * C0)])},
)

SHOCK_WAVE = release_wave(cut, MASS, tension0=450e3)


def shock_tension(seen: Seen):
    place = from_end(seen)
    middle = 0.5 * (place[1:] + place[:-1])
    return SHOCK_WAVE.tension(middle / seen.time[:, None])


SHOCK = Case(
    text=timed(ROPE, 0.048).replace('time = "5 ms"', "time = 0").replace("45 kN", "450 kN")
    .replace("tension_only = false", "tension_only = true"),
    seen=lambda seen: seen.tension,
    exact=shock_tension,
    scale=450e3,
    mean=True,
    # a front of 298 kN some three segments wide, half of it wrong, and as much for its foot
    bound=lambda n: 3.0 / n * 298.0 / 450.0,
    segments=40,
    source="lower convex envelope; Oleinik (1957)",
    order=(0.5, 1.2),
    step_order=None,
    plain=False,  # it converges to a front that is 1.5 ms late
)  # fmt: skip

CASES = {
    "linear release, at once": AT_ONCE,
    "linear release, ramped": RAMPED,
    "line that relaxes": RELAXING,
    "rarefaction": RAREFACTION,
    "plateau": PLATEAU,
    "shock": SHOCK,
}
