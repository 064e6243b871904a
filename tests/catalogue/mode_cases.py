"""Cases that swing in one natural mode: bars, strings, chains, beams, springs."""

import jax
import jax.numpy as jnp
import numpy as np
from case import Case
from player import Seen
from scipy.optimize import brentq
from scipy.special import j0, j1, jn_zeros

from lumpedcable.exact import beam_frequencies

HOOKE = """
[materials.hooke]
law = "linear"
EA = "1 MN"
{damping}
"""
OUTPUT = """
[output]
duration = {duration}
every = {every}
quantities = ["position", "velocity", "tension"]
"""
BAR = """
[lines.rope]
material = "hooke"
length = "100 m"
segments = 16
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {end}
"""
LENGTH, EA, MASS = 100.0, 1e6, 1.0  # of BAR: waves run at 1000 m/s


def outputs(duration: float, count: int = 16) -> str:
    return OUTPUT.format(duration=duration, every=duration / count)


def hooke(damping: float | None = None) -> str:
    return HOOKE.format(damping="" if damping is None else f"damping = {damping}")


def along(axis: int, values, nodes: int):
    """Vectors (nodes, 3) with `values` along one axis."""
    result = np.zeros((nodes, 3))
    result[:, axis] = values
    return result


def shaped(axis: int, shape):
    """A kick of shape(s) (m) along an axis, without speed."""
    return lambda s, _: (along(axis, shape(s), s.size), np.zeros((s.size, 3)))


def derivative(f, at: float):
    """f(x)' of a closed form in jax.numpy, for the reader of a case."""
    return lambda seen: np.asarray(jax.jacfwd(lambda x: f(seen, x))(at))


def phase_bound(angle: float, wave: float):
    """Bound from a chain's dispersion: (k l)^2/24 of the phase omega t, and a tenth for its square.

    angle: omega t at the end; wave: k L. From the chain's omega = (2 c/l) sin(k l/2).
    """
    return lambda n: 1.1 * angle * (wave / n) ** 2 / 24.0


# --- a bar between two walls ----------------------------------------------------------------------

K = np.pi / LENGTH
W = K * np.sqrt(EA / MASS)  # rad/s
SWING = 1e-3  # m


def bar_wave(seen: Seen, stiffness=EA, mass=MASS):
    """u = A sin(k s) cos(omega t), omega = k sqrt(EA/m), (times, nodes)."""
    w = K * jnp.sqrt(stiffness / mass)
    return SWING * jnp.sin(K * seen.s) * jnp.cos(w * seen.time)[:, None]


STANDING = Case(
    text=hooke() + BAR.format(end="{ fixed = [100, 0, 0] }") + outputs(0.16),
    kick=shaped(0, lambda s: SWING * np.sin(K * s)),
    seen=lambda seen: seen.moved[..., 0],
    exact=bar_wave,
    scale=SWING,
    bound=phase_bound(W * 0.16, np.pi),
    segments=16,
    source="Graff, Wave Motion in Elastic Solids (1975), chapter 2",
    gradients={
        "materials.hooke.EA": derivative(bar_wave, EA),
        "lines.rope.mass": derivative(lambda seen, m: bar_wave(seen, mass=m), MASS),
    },
)
DAMPING = 6e3  # N s: 2.96 1/s, a tenth of critical


def damped_wave(seen: Seen, damping=DAMPING):
    """m u_tt = EA u_ss + c u_sst: gamma = c k^2/(2 m), omega_d^2 = omega^2 - gamma^2; from rest."""
    g = damping * K**2 / (2.0 * MASS)
    w = jnp.sqrt(W**2 - g**2)
    t = seen.time[:, None]
    fall = jnp.exp(-g * t) * (jnp.cos(w * t) + g / w * jnp.sin(w * t))
    return SWING * jnp.sin(K * seen.s) * fall


DAMPED = Case(
    text=hooke(DAMPING) + BAR.format(end="{ fixed = [100, 0, 0] }") + outputs(0.16),
    kick=shaped(0, lambda s: SWING * np.sin(K * s)),
    seen=lambda seen: seen.moved[..., 0],
    exact=damped_wave,
    scale=SWING,
    bound=phase_bound(W * 0.16, np.pi),
    segments=16,
    source="Meirovitch, Fundamentals of Vibrations (2001), section 1.6, on each mode",
    # the damping force lags by half a step, which is first order in the step, and so of second order in
    # the mesh, with whose square the step goes
    refined=4,
    step_order=(0.8, 1.2),
    gradients={"materials.hooke.damping": derivative(damped_wave, DAMPING)},
    # the lag of half a step turns this derivative by omega dt/2; five steps of 2 ms an output
    gradient_bound=lambda n: phase_bound(W * 0.16, np.pi)(n) + 0.5 * W * 2e-3,
)

# --- a body on a heavy spring ---------------------------------------------------------------------

BOB, SPRING = 20.0, 10.0  # kg; m of a line of 1 kg/m
ROOT = brentq(lambda b: b * np.tan(b) - MASS * SPRING / BOB, 1e-6, 1.5)
BOUNCE = ROOT / SPRING * np.sqrt(EA / MASS)


def bouncing(seen: Seen, stiffness=EA):
    """u = A sin(b s/L) cos(omega t), omega = (b/L) sqrt(EA/m), b tan(b) = m L/M; down is negative."""
    w = ROOT / SPRING * jnp.sqrt(stiffness / MASS)
    return -SWING * jnp.sin(ROOT * seen.s / SPRING) * jnp.cos(w * seen.time)[:, None]


def bob_bound(n: int) -> float:
    """Phase of the lumped spring, by Rayleigh's quotient with the exact shape sin(b s/L).

    With x = sin(2 b)/(2 b), omega^2 is lower by (k l)^2 (1/12 + x/(6 (1 + x))): differences and
    the midpoint rule for the springs, the trapezoidal rule for the masses.
    """
    x = np.sin(2.0 * ROOT) / (2.0 * ROOT)
    return phase_bound(BOUNCE * 0.1, ROOT)(n) * (1.0 + 2.0 * x / (1.0 + x))


HANGS = BAR.replace("100 m", "10 m").format(end='"bob"') + f"[bodies.bob]\nmass = {BOB}\n"
BODY = Case(
    text="gravity = 9.81\n" + hooke() + HANGS + outputs(0.1),
    kick=shaped(2, lambda s: -SWING * np.sin(ROOT * s / SPRING)),
    seen=lambda seen: seen.moved[..., 2],
    exact=bouncing,
    scale=SWING * np.sin(ROOT),
    bound=bob_bound,
    segments=8,
    source="Graff (1975), chapter 2: rod with a mass at its end",
    gradients={"materials.hooke.EA": derivative(bouncing, EA)},
)


SPRING_W = np.sqrt(EA / SPRING / (BOB + 0.5 * MASS * SPRING))


def on_a_spring(seen: Seen, mass=BOB):
    """One segment: half of its mass joins the body, omega^2 = EA/(L (M + m L/2))."""
    w = jnp.sqrt(EA / SPRING / (mass + 0.5 * MASS * SPRING))
    return -SWING * jnp.cos(w * seen.time)[:, None]


SPRINGY = Case(
    text="gravity = 9.81\n" + hooke() + HANGS + outputs(0.1),
    kick=shaped(2, lambda s: -SWING * s / SPRING),
    seen=lambda seen: seen.moved[..., -1:, 2],
    exact=on_a_spring,
    scale=SWING,
    # no error in space: leapfrog's own phase, (omega dt)^2/24, dt at most an output interval
    bound=lambda n: 1.1 * 0.1 * SPRING_W * (SPRING_W * 0.1 / 16) ** 2 / 24.0,
    segments=1,
    source="mass on a spring, m u'' = -k u",
    order=None,
    gradients={"bodies.bob.mass": derivative(on_a_spring, BOB)},
)

# --- strings and chains ---------------------------------------------------------------------------

END = 105.0  # m: 5 % strain


def string_wave(seen: Seen, end=END):
    """y = A sin(k s) cos(omega t), omega^2 = k^2 T/(m (1 + e)), s and m of the unstretched line."""
    e = end / LENGTH - 1.0
    w = K * jnp.sqrt(EA * e / MASS / (1.0 + e))
    return SWING * jnp.sin(K * seen.s) * jnp.cos(w * seen.time)[:, None]


STRING_W = K * np.sqrt(EA * 0.05 / MASS / 1.05)
STRING = Case(
    text="dimensions = 2\n" + hooke() + BAR.format(end="{ fixed = [105, 0, 0] }") + outputs(0.8),
    kick=shaped(1, lambda s: SWING * np.sin(K * s)),
    seen=lambda seen: seen.moved[..., 1],
    exact=string_wave,
    scale=SWING,
    bound=phase_bound(STRING_W * 0.8, np.pi),
    segments=16,
    source="Irvine, Cable Structures (1981), chapter 3, without sag",
    gradients={"lines.rope.end.fixed.0": derivative(string_wave, END)},
)

G, CHAIN = 9.81, 10.0
CHAIN_W = 0.5 * jn_zeros(0, 1)[0] * np.sqrt(G / CHAIN)


def chain_shape(s):
    """J0(2 omega sqrt((L - s)/g))."""
    return j0(2.0 * CHAIN_W * np.sqrt(np.maximum(CHAIN - s, 0.0) / G))


def chain_bound(n: int) -> float:
    """Phase of a chain's dispersion, its (k l)^2 weighted by the energy of bending the shape.

    k^2 = omega^2/(g x) at a height x above the free end, energy w x y'^2; and as much again for what
    this estimate to first order leaves out, and for the line's stretch of 1e-4.
    """
    x = np.linspace(1e-6, CHAIN, 20_001)
    slope = j1(2.0 * CHAIN_W * np.sqrt(x / G)) / np.sqrt(x)
    square = CHAIN_W**2 / G * np.sum(slope**2) / np.sum(x * slope**2)
    return 2.0 * CHAIN_W * 4.0 * square * (CHAIN / n) ** 2 / 24.0 + 1e-4 * CHAIN_W * 4.0


def by_gravity(seen: Seen):
    """d/dg of the mode: omega goes as the root of g, the shape stays."""
    t = CHAIN_W * seen.time
    return -SWING * chain_shape(seen.s) * (t * np.sin(t))[:, None] / (2.0 * G)


HANGING = Case(
    text=f"gravity = {G}\ndimensions = 2\n" + hooke()
    + BAR.replace("100 m", "10 m").format(end='"free"') + outputs(4.0),
    kick=shaped(0, lambda s: SWING * chain_shape(s)),
    seen=lambda seen: seen.moved[..., 0],
    exact=lambda seen: SWING * chain_shape(seen.s) * np.cos(CHAIN_W * seen.time)[:, None],
    scale=SWING,
    bound=chain_bound,
    segments=12,
    source="D. Bernoulli (1733), see Watson, Theory of Bessel Functions (1944), chapter 1",
    order=(1.6, 2.4),
    gradients={"gravity": by_gravity},
)  # fmt: skip

# --- a beam ---------------------------------------------------------------------------------------

BEAM, EI, BEAM_MASS = 10.0, 1e4, 5.0
BEAM_SWING = 1e-5  # m: small enough for the pull that bending causes to be nothing
BEAM_W = 2.0 * np.pi * beam_frequencies(BEAM, EI, BEAM_MASS, 1)[0]
BEAM_K = (BEAM_W**2 * BEAM_MASS / EI) ** 0.25


def beam_shape(s):
    """cosh - cos - r (sinh - sin), 2 at the free end; Graff (1975), chapter 3."""
    x, b = BEAM_K * s, BEAM_K * BEAM
    r = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    return np.cosh(x) - np.cos(x) - r * (np.sinh(x) - np.sin(x))


def beam_bound(n: int) -> float:
    """Phase of the lumped beam, by Rayleigh's quotient of its sums with the exact shape y.

    Curvature from three nodes, at the clamp from two, summed by the trapezoidal rule: omega^2 is
    lower by l^2/6 (int y'''^2/int y''^2 + y(L) y'(L)/int y^2), and a tenth for higher orders.
    """
    s = np.linspace(0.0, BEAM, 2001)
    y = beam_shape(s)
    y1 = np.gradient(y, s, edge_order=2)
    y2 = np.gradient(y1, s, edge_order=2)
    y3 = np.gradient(y2, s, edge_order=2)
    share = np.sum(y3**2) / np.sum(y2**2) + y[-1] * y1[-1] / (np.sum(y**2) * s[1])
    return 1.1 * 0.5 * BEAM_W * 4.0 * (BEAM / n) ** 2 / 6.0 * share


def beam_wave(seen: Seen, stiffness=EI):
    """y = A shape(s) cos(omega t); the shape does not depend on EI."""
    w = BEAM_W * jnp.sqrt(stiffness / EI)
    return BEAM_SWING * beam_shape(seen.s) * jnp.cos(w * seen.time)[:, None]


CANTILEVER = Case(
    text=f"""dimensions = 2
{hooke()}
[lines.rope]
material = "hooke"
length = {BEAM}
segments = 16
mass = {BEAM_MASS}
bending = {{ EI = {EI} }}
start = {{ fixed = [0, 0, 0], direction = [1, 0, 0] }}
end = "free"
{outputs(4.0)}""",
    kick=shaped(1, lambda s: BEAM_SWING * beam_shape(s)),
    seen=lambda seen: seen.moved[..., 1],
    exact=beam_wave,
    scale=2.0 * BEAM_SWING,
    bound=beam_bound,
    step_order=None,  # the shape is not quite the chain's own: high modes ring, below the step
    segments=16,
    source="Graff (1975), chapter 3: clamped and free",
    order=(1.6, 2.4),
    gradients={"lines.rope.bending.EI": derivative(beam_wave, EI)},
)

CASES = {
    "standing axial wave": STANDING,
    "damped axial mode": DAMPED,
    "body on a heavy line": BODY,
    "body on one segment": SPRINGY,
    "taut string": STRING,
    "hanging chain": HANGING,
    "cantilever": CANTILEVER,
}
