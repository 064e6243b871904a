"""The end of a run before its time is over: its body comes to rest, or its rods lose their lengths."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.model import Model
from lumpedcable.model.state import State
from lumpedcable.solve.plan import Plan, Progress

__all__ = ["halted", "held", "rests", "time_of"]

HALF_STEPS = ("leapfrog", "constrained")  # they keep velocities in the middle of steps
ROUNDING = 1e3  # times eps: a share of the first speed that is none


def halted(model: Model, plan: Plan, run: Progress, after: Progress, t0, dt) -> Progress:
    """A run after a step, or before it if its body has come to rest.

    Where derivatives are wanted, the state at the stop is that of the very instant: the end of a step
    would change by leaps with the numbers of the scene.
    """
    assert plan.stop is not None
    when, stops = _stop(model, plan, run, after, t0, dt)
    stops &= jnp.isnan(run.stopped)
    done = rests(model, plan, run)
    kept = jax.tree.map(lambda old, new: jnp.where(done, old, new), run, after)
    if plan.sloped:
        instant = _instant(run.y, after.y, jnp.where(stops, when - t0, 0.0), dt)
        y = jax.tree.map(lambda now, new: jnp.where(stops, now, new), instant, kept.y)
        kept = kept._replace(y=y)
    return kept._replace(stopped=jnp.where(stops, when, run.stopped))


def held(run: Progress, after: Progress, fails: Bool[Array, ""]) -> Progress:
    """A run after a step, or from a step on that fails before it."""
    lost = run.lost | fails
    kept = jax.tree.map(lambda old, new: jnp.where(lost, old, new), run, after)
    return kept._replace(lost=lost)


def rests(model: Model, plan: Plan, run: Progress) -> Bool[Array, ""]:
    """Whether a run that may stop has come to its end; without derivatives, without any speed."""
    if plan.stop is None:
        return jnp.zeros((), bool)
    along = model.bodies[plan.stop].start_velocity
    assert along is not None
    speed = jnp.dot(run.y.velocity[body_key(plan.stop)], along)
    still = plan.sloped | (speed <= _nothing(along))
    return (~jnp.isnan(run.stopped) & still) | run.lost


def time_of(model: Model, plan: Plan, run: Progress, t: Float[Array, ""]) -> Float[Array, ""]:
    """When a run is in the state that it has at the output time t (s): at most when it has stopped."""
    if plan.stop is None:
        return t
    ended = rests(model, plan, run) & ~jnp.isnan(run.stopped)
    return jnp.minimum(t, jnp.where(ended, run.stopped, jnp.inf))


def _nothing(along: Float[Array, " m"]) -> Float[Array, ""]:
    """v . v0 (m2/s2) of a speed v that is rounding beside the first one v0, `along` (m/s)."""
    return ROUNDING * float(jnp.finfo(along.dtype).eps) * jnp.dot(along, along)


def _stop(model: Model, plan: Plan, run: Progress, after: Progress, t0, dt):
    """When the body comes to rest (s), and whether it does so in this step.

    The zero of its speed, linear between half steps where the method keeps those. Friction that holds a
    body leaves it a speed of zero, or of what rounding is of the first one, until the end of the kick:
    there the slope is that of the kick before.
    """
    assert plan.stop is not None
    key, along = body_key(plan.stop), model.bodies[plan.stop].start_velocity
    assert along is not None
    now, then = (jnp.dot(x.y.velocity[key], along).astype(dt.dtype) for x in (run, after))
    none = _nothing(along).astype(dt.dtype)
    if plan.method in HALF_STEPS:
        whole = now
        now, then = (
            jnp.dot(x.solver_state.velocity[key], along).astype(dt.dtype) for x in (run, after)
        )
        drop = jnp.where(jnp.abs(then) <= none, jnp.maximum(now, 2.0 * (whole - now)), now - then)
        t0 = t0 + 0.5 * dt
    else:
        drop = now - then
    stops = then <= none
    return t0 + dt * jnp.where(stops, now, 0.0) / jnp.where(stops & (drop > 0.0), drop, 1.0), stops


def _instant(y0: State, y1: State, after, dt) -> State:
    """The state so long (s) after the first of two that lie a step dt (s) apart.

    Coordinates are the parabola through both places and the first velocity, velocities its slope.
    """
    share = after / dt

    def place(x0, x1, v0):
        return (x0 + after * v0 + share**2 * (x1 - x0 - dt * v0)).astype(x0.dtype)

    def rate(x0, x1, v0):
        return (v0 + 2.0 * share * ((x1 - x0) / dt - v0)).astype(v0.dtype)

    def line(a, b):
        return (a + share * (b - a)).astype(a.dtype)

    ways = y0.displacement, y1.displacement, y0.velocity
    moved, rates = jax.tree.map(place, *ways), jax.tree.map(rate, *ways)
    pairs = (y0.work, y1.work), (y0.tension, y1.tension), (y0.memory, y1.memory)
    work, tension, memory = (jax.tree.map(line, *pair) for pair in pairs)
    return State(moved, rates, work, y1.reaction, tension, memory)
