"""Cases that move as a whole or are moved: pendulum, free fall, fall in water, a shaken end."""

import jax.numpy as jnp
import numpy as np
from case import Case
from mode_cases import BAR, derivative, hooke, outputs
from player import Seen
from scipy.special import ellipj, ellipk

G = 9.81
LENGTH, BOB = 10.0, 10.0  # m of a line of 1 kg/m, kg
SWUNG = 0.9  # rad
BOUNCE = np.sqrt(1e7 / LENGTH / (BOB + 0.5 * LENGTH))  # rad/s, up and down on the line
STRETCHED = LENGTH * (1.0 + (BOB + 0.5 * LENGTH) * G / 1e7)  # m; EA is 10 MN

# --- a pendulum -----------------------------------------------------------------------------------


def angle(t, length=STRETCHED):
    """Angle (rad) of a pendulum let go at `SWUNG`: sin(a/2) = k cd(omega t), k = sin(SWUNG/2).

    Landau & Lifshitz, Mechanics (1976), section 11, problem 1, with Jacobi's functions.
    """
    k = np.sin(0.5 * SWUNG)
    sn, *_ = ellipj(ellipk(k**2) - np.sqrt(G / length) * t, k**2)
    return 2.0 * np.arcsin(k * sn)


def bob_place(seen: Seen, length=STRETCHED):
    """x, z (m) of the bob less its place at rest, (times, 1, 2)."""
    a = angle(seen.time, length)
    return length * np.stack([np.sin(a), 1.0 - np.cos(a)], axis=-1)[:, None]


def swung(s, place):
    """The line turned about its top by SWUNG."""
    a = SWUNG
    turned = jnp.stack([-place[:, 2] * np.sin(a), 0.0 * s, place[:, 2] * np.cos(a)], axis=-1)
    return turned - place, 0.0 * place


def by_length(seen: Seen):
    """d(place)/dL by central differences of the closed form, sixth order in 1 %."""
    h, parts = 1e-2 * LENGTH, ((1, 45.0), (2, -9.0), (3, 1.0))
    stretch = STRETCHED / LENGTH
    return sum(
        w * (bob_place(seen, STRETCHED + k * h) - bob_place(seen, STRETCHED - k * h))
        for k, w in parts
    ) / (60.0 * h) * stretch  # fmt: skip


PENDULUM = Case(
    text=f"gravity = {G}\ndimensions = 2\n" + hooke().replace("1 MN", "10 MN")
    + BAR.replace("100 m", "10 m").format(end='"bob"') + f"[bodies.bob]\nmass = {BOB}\n" + outputs(7.0),
    kick=swung,
    seen=lambda seen: seen.moved[..., -1:, ::2],
    exact=bob_place,
    scale=LENGTH,
    # the line carries m g cos(a) at first, not m g: it bounces by that much of its stretch, which
    # also changes its length and so the phase sqrt(g/L) t
    bound=lambda n: 2.0 * (STRETCHED / LENGTH - 1.0) * (1.0 + 0.5 * np.sqrt(G / LENGTH) * 7.0),
    segments=1,
    source="Landau & Lifshitz, Mechanics (1976), section 11, problem 1",
    order=None,
    step_order=None,  # the step resolves the bounce, and that is not what is looked at
    euler=1e-3,
    gradients={"lines.rope.length": by_length},
    # the bounce's own phase, half of omega t per share of length, times its size; over what is
    # looked for, t/(2 L) of the largest speed
    gradient_bound=lambda n: (
        (STRETCHED / LENGTH - 1.0) * LENGTH * BOUNCE / (2.0 * np.sqrt(G * LENGTH) * np.sin(SWUNG / 2))
    ),
)  # fmt: skip

# --- falling --------------------------------------------------------------------------------------

CUT = '[events.cut]\nbreaks = "rope.start"\ntime = 0\n'
ROPE = BAR.replace("100 m", "10 m").format(end='"free"')


def middle(seen: Seen):
    """Height of the centre of mass above where it was (m), (times,): end nodes count half."""
    z = seen.moved[..., 2]
    inner = z[..., 1:-1].sum(-1)
    return (inner + 0.5 * (z[..., 0] + z[..., -1])) / (z.shape[-1] - 1)


FALL = Case(
    text=f"gravity = {G}\n" + hooke() + ROPE + CUT + outputs(1.6),
    seen=middle,
    exact=lambda seen: -0.5 * G * seen.time**2,
    scale=0.5 * G * 1.6**2,
    # the cut sends a wave of g L/c along the line. What its ends do behind a corrected front is not
    # paid for by their neighbours: of half a segment, that speed, for a few steps
    bound=lambda n: G * LENGTH / 1e3 * 1.6 / n / (0.5 * G * 1.6**2),
    segments=8,
    source="Newton's second law for a whole",
    order=None,
    step_order=None,
    gradients={"gravity": lambda seen: -0.5 * seen.time**2},
)
WATER, DIAMETER, NORMAL = 1025.0, 0.02, 1.2
ADDED = WATER * np.pi / 4 * DIAMETER**2


def sinking(seen: Seen, normal=NORMAL):
    """v = -V tanh(a t/V) of every node, (times, nodes): a = w/(m + m_a), V^2 = 2 w/(rho d Cn)."""
    weight = (1.0 - ADDED) * G
    final = jnp.sqrt(2.0 * weight / (WATER * DIAMETER * normal))
    v = -final * jnp.tanh(weight / (1.0 + ADDED) * seen.time / final)
    return v[:, None] + jnp.zeros(seen.s.shape)


def laid_flat(s, place):
    """Along x instead of down, unstretched, at the height of the fixed end."""
    flat = np.stack([s, 0.0 * s, 0.0 * s], axis=-1)
    return flat - place, 0.0 * place


SINKS = Case(
    text=f"gravity = {G}\ndimensions = 2\n[water]\ndensity = {WATER}\n" + hooke()
    + ROPE.replace("mass =", f"diameter = {DIAMETER}\ndrag = {{ normal = {NORMAL}, "
                   "tangential = 0.01 }\nadded_mass = { normal = 1.0 }\nmass =")
    + CUT + outputs(1.6),
    kick=laid_flat,
    seen=lambda seen: seen.velocity[..., 2],
    exact=sinking,
    scale=float(np.sqrt(2.0 * (1.0 - ADDED) * G / (WATER * DIAMETER * NORMAL))),
    # every node does the same: no error in space. (a dt/V)^2 of leapfrog's step is 2e-4
    bound=lambda n: 2e-4,
    segments=4,
    source="Newton, Principia, book II: dv/dt = g - k v^2",
    order=None,
    euler=1e-2,
    gradients={"lines.rope.drag.normal": derivative(sinking, NORMAL)},
)  # fmt: skip

# --- a shaken end ---------------------------------------------------------------------------------

SPAN, SHAKE, PERIOD, RAMP = 100.0, 1e-3, 0.1, 0.1  # m, m, s, s


def shaken(seen: Seen, amplitude=SHAKE, period=PERIOD):
    """u = f(t - (L - s)/c), f the motion of the end: until the wave is at the other end, at L/c."""
    late = jnp.maximum(seen.time[:, None] - (SPAN - seen.s) / 1e3, 0.0)
    grown = jnp.sin(0.5 * jnp.pi * jnp.minimum(late / RAMP, 1.0)) ** 2
    return amplitude * grown * jnp.sin(2.0 * jnp.pi * late / period)


SHAKEN = Case(
    text=hooke() + BAR.format(
        end=f"{{ motion = {{ position = [100, 0, 0], amplitude = [{SHAKE}, 0, 0], "
        f"period = {PERIOD}, ramp = {RAMP} }} }}"
    ) + outputs(0.096),
    seen=lambda seen: seen.moved[..., 0],
    exact=shaken,
    scale=SHAKE,
    # the chain's dispersion over the distance travelled; growth makes waves of half the period too
    bound=lambda n: (2.0 * np.pi) ** 3 / n**2 / 24.0,
    segments=20,
    source="d'Alembert; Graff (1975), chapter 2",
    gradients={
        "lines.rope.end.motion.amplitude.0": derivative(shaken, SHAKE),
        "lines.rope.end.motion.period": derivative(
            lambda seen, period: shaken(seen, period=period), PERIOD
        ),
    },
)  # fmt: skip

CASES = {
    "pendulum": PENDULUM,
    "free fall": FALL,
    "sinking": SINKS,
    "shaken end": SHAKEN,
}
