"""The two remedies for wave fronts at each segment by itself: their tensions, and the slopes of these.

`ReleaseWaves` says what they are. The slopes are written down and not left to jax, which would work out
the pieces of a tension anew for each of them: a way back through time takes a quarter less so, and six
directions side by side as much less. Who changes one changes the other; a test holds them together.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.physics.each import settled
from lumpedcable.physics.vectors import least, most

__all__ = ["SOFT", "Given", "Values", "WaveTensions", "second_difference", "slopes", "tensions"]

LINEAR_VISCOSITY = 0.16
QUADRATIC_VISCOSITY = 0.5
VISCOSITY_SHARE_OF_LIMIT = 0.4
MORE_AT_LOAD = 1.5  # times as much viscosity in the segment of a loaded end,
LESS_LIMIT_AT_LOAD = 0.35  # within as much of the limit, since half a mass follows
SLACK_VISCOSITY = 0.25  # times l / dt: one step then evens out the shortest wave, without ringing
TURNED = 0.05  # rad that a line turns by over a segment and its neighbours where it folds
SOFT = 1e-30  # N: no stiffness, but one whose root has a derivative
SLACK_SHARE_OF_REST = 0.3  # of what the springs beside a slack segment leave of a stable step
STILL = 50.0  # times the rounding error of the wave speed: a jump of velocity that counts as none
STILL_IN_STAGES = 1e-7  # of the wave speed: what adaptive methods leave open of their stages


class WaveTensions(NamedTuple):
    """What the remedies add to the tension of each segment (N): both together, and each.

    The correction is None where it is not asked for.
    """

    total: Float[Array, " n"]
    correction: Float[Array, " n"] | None
    viscosity: Float[Array, " n"]


class Given(NamedTuple):
    """1 in segments of loaded ends; off the joint at each end; taut. None: nowhere, never asked."""

    there: Float[Array, " n"] | None
    off_joint: tuple[Bool[Array, " n"] | None, ...]
    taut: Bool[Array, " n"] | None


class Values(NamedTuple):
    """Numbers at each segment: of rate and tension its left neighbour's, its own and its right one's.

    `beside` are the stiffnesses of the two neighbours, None where no fixed step asks for them; `at_rest`
    is the second difference of the tensions at rest (N), None where it is nothing; `aligned` tells from
    1 to 0 how little the line turns there, None where it cannot, or where that is not asked.
    """

    rate: tuple[Float[Array, " n"], ...]
    stiffness: Float[Array, " n"]
    beside: tuple[Float[Array, " n"], ...] | None
    tension: tuple[Float[Array, " n"], ...] | None
    length: Float[Array, "..."]
    mass: Float[Array, ""]
    dt: Float[Array, ""] | None
    damping: Float[Array, ""] | None
    at_rest: Float[Array, " n"] | None = None
    aligned: Float[Array, " n"] | None = None


class _Pieces(NamedTuple):
    """What tensions are made of; viscosities in m/s, without material damping.

    `free` is the viscosity before its bound, of which `linear` is the part by the wave speed; the bound
    is `room` times (1 - nu^2)(3 - nu^2), if that is above 0; both None without one.
    """

    stiff: Float[Array, " n"]
    jump: Float[Array, " n"]
    smooth: "_Smooth"
    nu2: Float[Array, " n"]
    linear: Float[Array, " n"]
    free: Float[Array, " n"]
    room: Float[Array, "..."] | None
    bound: Float[Array, " n"] | None
    slack: "_Slack | None"
    viscosity: Float[Array, " n"]


class _Smooth(NamedTuple):
    """1 - phi; 1 / g, but 0 where g is still; whether the mean of the ratios decides, else whether the
    left one does.
    """

    rough: Float[Array, " n"]
    inverse: Float[Array, " n"]
    mean: Bool[Array, " n"]
    left: Bool[Array, " n"]


class _Slack(NamedTuple):
    """The nu^2 of the stiffer neighbour, the viscosity of a straight line (m/s), where it is taut."""

    near: Float[Array, " n"]
    whole: Float[Array, " n"]
    taut: Bool[Array, " n"]


def tensions(given: Given, values: Values) -> WaveTensions:
    """The formulas of `ReleaseWaves`."""
    return _assembled(given, values, _pieces(given, values, lambda x: x))


def _pieces(given: Given, values: Values, keep) -> _Pieces:
    """What `tensions` are made of; `keep` is asked of what is used often."""
    rate, length, mass, dt = values.rate[1], values.length, values.mass, values.dt
    # factors that are the same at every step come first, in brackets: they are worked out once
    stiff = most(values.stiffness, SOFT)
    speed = jnp.sqrt(stiff * (1.0 / mass))
    jump = rate * length
    left, own, right = values.rate
    noise = STILL * float(jnp.finfo(rate.dtype).eps)
    noise = (noise if dt is not None else max(noise, STILL_IN_STAGES)) * speed / length
    smooth = _smoothness(left, own, right, noise, values.tension is not None, given.taut)
    smooth = smooth._replace(rough=keep(smooth.rough))
    linear = LINEAR_VISCOSITY * speed
    free = linear + QUADRATIC_VISCOSITY * jnp.abs(jump)
    share = VISCOSITY_SHARE_OF_LIMIT
    if given.there is not None:
        more = 1.0 + (MORE_AT_LOAD - 1.0) * given.there
        linear, free = linear * more, free * more
        share = share * (1.0 + (LESS_LIMIT_AT_LOAD - 1.0) * given.there)
    free = keep(free)
    if dt is None:
        still = jnp.zeros_like(stiff)
        return _Pieces(stiff, jump, smooth, still, linear, free, None, None, None, free)
    nu2 = stiff * ((dt / length) ** 2 / mass)
    room = share / 6.0 * length / dt
    bound = keep(most((1.0 - nu2) * (3.0 - nu2) * room, 0.0))
    viscosity, slack = least(free, bound), None
    if values.beside is not None:
        assert given.taut is not None
        near = most(most(*values.beside), SOFT) * ((dt / length) ** 2 / mass)
        slack = _Slack(near, _slack_share(near, jump) * (length / dt), given.taut)
        share = slack.whole if values.aligned is None else slack.whole * values.aligned
        viscosity = jnp.where(given.taut, viscosity, share)
    return _Pieces(stiff, jump, smooth, nu2, linear, free, room, bound, slack, keep(viscosity))


def _less_damping(values: Values, pieces: _Pieces):
    """The viscosity (m/s) less what material damping does already; and where some of it is left.

    In slack segments it is what it is. Without material damping the second is None.
    """
    b = pieces.viscosity
    if values.damping is None:
        return b, None
    left = b - values.damping / (values.mass * values.length)
    eased = left > 0.0
    left = most(left, 0.0)
    if pieces.slack is None:
        return left, eased
    return jnp.where(pieces.slack.taut, left, b), eased & pieces.slack.taut


def _uncut(given: Given, values: Values, pieces: _Pieces):
    """The correction (N) before a line that cannot push cuts it; and what it is with f = 0."""
    whole = (pieces.nu2 - 1.0) * (1.0 / 12.0) * _bend(values)
    correction = (1.0 - pieces.smooth.rough * pieces.smooth.rough) * whole
    for inside in given.off_joint:
        correction = correction if inside is None else jnp.where(inside, correction, 0.0)
    return correction, whole


def _bend(values: Values) -> Float[Array, " n"]:
    """The second difference of the tensions (N), less what it is at rest."""
    assert values.tension is not None
    bend = second_difference(*values.tension)
    return bend if values.at_rest is None else bend - values.at_rest


def second_difference(before, own, after) -> Float[Array, " n"]:
    """x_j+1 - 2 x_j + x_j-1 of values and what is left and right of each."""
    return after - 2.0 * own + before


def _assembled(given: Given, values: Values, pieces: _Pieces) -> WaveTensions:
    f = pieces.smooth.rough * pieces.smooth.rough
    b, _ = _less_damping(values, pieces)
    viscous = values.mass * b * pieces.jump * f
    if values.tension is None:
        return WaveTensions(viscous, None, viscous)
    correction, _ = _uncut(given, values, pieces)
    if given.taut is not None:
        correction = most(correction, -values.tension[1])
    return WaveTensions(correction + viscous, correction, viscous)


def _slack_share(nu2: Float[Array, " n"], jump: Float[Array, " n"]) -> Float[Array, " n"]:
    """Viscosity of slack segments in l / dt: `SLACK_VISCOSITY`, less where its lag would ring.

    A node between a slack and a taut segment has the taut one's spring besides, of the nu^2 given, and
    both must fit into a step. A segment that comes apart becomes taut itself and needs no such care.
    """
    left = most(1.0 - nu2, 0.0)
    less = least(SLACK_SHARE_OF_REST * left, SLACK_VISCOSITY)
    return jnp.where(jump > 0.0, SLACK_VISCOSITY, less)


def _smoothness(left, rate, right, noise, corrected, taut) -> _Smooth:
    """1 - phi of each segment from the strain rates (1/s) of its neighbours and its own, and why.

    phi is 1 where the rate is below `noise` (1/s), or next to nothing beside a neighbour's.
    """
    beside = most(jnp.abs(left), jnp.abs(right))
    # a rate whose square underflows would have an inverse that no derivative can be taken of
    noise = most(noise, float(jnp.finfo(rate.dtype).tiny) ** 0.5)
    still = jnp.abs(rate) <= most(noise, float(jnp.finfo(rate.dtype).eps) ** 0.5 * beside)
    # 0 tells where a rate is still: the condition itself would be kept in bytes, which takes longer
    inverse = jnp.where(still, 0.0, 1.0 / jnp.where(still, 1.0, rate))
    one, rl, rr = rate * inverse, left * inverse, right * inverse
    by_mean, by_lesser = one - 0.5 * (rl + rr), one - 2.0 * least(rl, rr)
    if corrected:  # a taut segment that shortens is let off the second rule
        shortens = rate < 0.0 if taut is None else (rate < 0.0) & taut
        by_lesser = jnp.where(shortens, 0.0, by_lesser)
    rough = least(most(most(by_mean, by_lesser), 0.0), 1.0)
    return _Smooth(rough, inverse, by_mean > by_lesser, rl < rr)


def slopes(given: Given, values: Values) -> tuple[WaveTensions, WaveTensions]:
    """The tensions; and in the place of each its slopes by all values, None for nothing."""
    pieces = _pieces(given, values, settled)
    found = _assembled(given, values, pieces)
    viscous = _slopes(given, values, pieces, corrected=False)
    if values.tension is None:
        return found, WaveTensions(viscous, None, viscous)  # type: ignore[arg-type]
    total = _slopes(given, values, pieces, corrected=True)
    form = jax.tree.structure(values)
    both = zip(form.flatten_up_to(total), form.flatten_up_to(viscous), strict=True)
    correction = form.unflatten([a if b is None else a - b for a, b in both])
    return found, WaveTensions(total, correction, viscous)  # type: ignore[arg-type]


def _slopes(given: Given, values: Values, pieces: _Pieces, corrected: bool) -> Values:
    """Slopes of Q = m b D f and, if `corrected`, of C as well, so that what they share is found once."""
    mass, length, dt = values.mass, values.length, values.dt
    stiff, jump, nu2, rough = pieces.stiff, pieces.jump, pieces.nu2, pieces.smooth.rough
    f = rough * rough
    b, eased = _less_damping(values, pieces)
    by = _slopes_of_viscosity(values, pieces, eased)
    by_b, by_f = mass * jump * f, mass * jump * b
    bend = jnp.zeros_like(f)
    by_tension: Any = None if values.tension is None else (None, None, None)
    at_rest = None
    if corrected:
        by_tension, straight, bend = _slopes_of_correction(given, values, pieces)
        at_rest = None if values.at_rest is None else -by_tension[0]
        by_f = by_f - straight
    # phi is not below 0; where it would be above 1, so is the slope of the square of 1 - phi 0
    by_phi = settled(by_f * jnp.where(rough < 1.0, -2.0 * rough * pieces.smooth.inverse, 0.0))
    mean, left = pieces.smooth.mean, pieces.smooth.left
    by_rate = (
        by_phi * jnp.where(mean, 0.5, jnp.where(left, 2.0, 0.0)),
        mass * f * length * (b + by.jump) - by_phi * (1.0 - rough),
        by_phi * jnp.where(mean, 0.5, jnp.where(left, 0.0, 2.0)),
    )
    soft = values.stiffness <= SOFT
    by_stiffness = settled(jnp.where(soft, 0.0, (by_b * by.stiff + bend * nu2) / stiff))
    # b and nu^2 know stiffnesses over the mass alone, and the mass is a factor of Q besides
    by_mass = f * jump * b - by_stiffness * (stiff / mass)
    beside = None
    if by.near is not None:
        assert values.beside is not None
        first, second = values.beside
        # none is below 0, so that its sign can tell of which of the two it is
        by_near = by_b * by.near
        by_near = settled(jnp.where(first > second, by_near, -by_near))
        beside = most(by_near, 0.0), most(-by_near, 0.0)
        by_mass = by_mass - jnp.abs(by_near) * (most(first, second) / mass)
    by_length = (by_b * (b + by.jump + by.size) - 2.0 * bend * nu2) / length
    by_dt = None if dt is None else (2.0 * bend * nu2 - by_b * by.size) / dt
    by_damping = None
    if values.damping is not None and eased is not None:
        by_damping = jnp.where(eased, -by_b, 0.0) / (mass * length)
        by_mass = by_mass - by_damping * (values.damping / mass)
        by_length = by_length - by_damping * (values.damping / length)
    by_aligned = None
    if values.aligned is not None:
        assert pieces.slack is not None
        by_aligned = jnp.where(pieces.slack.taut, 0.0, by_b * pieces.slack.whole)
    return Values(
        by_rate, by_stiffness, beside, by_tension, by_length, by_mass, by_dt, by_damping, at_rest,
        by_aligned,
    )  # fmt: skip


class _OfViscosity(NamedTuple):
    """s db/ds with the segment's stiffness s, D db/dD with its jump D, l db/dl with its length at the
    same jump, which is -dt db/ddt (m/s); and db/dn with the stiffer neighbour's stiffness n, None where
    nothing can be slack. All without material damping but where that leaves no viscosity.
    """

    stiff: Float[Array, " n"]
    jump: Float[Array, " n"]
    size: Float[Array, " n"]
    near: Float[Array, " n"] | None


def _slopes_of_viscosity(values: Values, pieces: _Pieces, eased) -> _OfViscosity:
    nu2, viscosity, slack = pieces.nu2, pieces.viscosity, pieces.slack
    stiff, size, by_near = 0.5 * pieces.linear, jnp.zeros_like(viscosity), None
    free = jnp.ones(viscosity.shape, bool)
    if pieces.room is not None and pieces.bound is not None:
        # asked anew: compiled, the viscosity and `free` need not be equal to the last bit where they are
        free = pieces.free < pieces.bound
        bound = jnp.where(pieces.bound > 0.0, nu2 * (2.0 * nu2 - 4.0) * pieces.room, 0.0)
        stiff = jnp.where(free, stiff, bound)
        size = jnp.where(free, 0.0, viscosity - 2.0 * bound)
    if slack is not None:
        assert values.dt is not None
        free, stiff = free & slack.taut, jnp.where(slack.taut, stiff, 0.0)
        left = 1.0 - slack.near
        bent = (left > 0.0) & (SLACK_SHARE_OF_REST * left < SLACK_VISCOSITY)
        bent = bent & (pieces.jump <= 0.0) & ~slack.taut
        per_stiffness = (values.dt / values.length) ** 2 / values.mass
        by_near = -SLACK_SHARE_OF_REST * (values.length / values.dt) * per_stiffness
        by_near = by_near if values.aligned is None else by_near * values.aligned
        by_near = jnp.where(bent & (slack.near > SOFT * per_stiffness), by_near, 0.0)
        of_slack = viscosity - 2.0 * by_near * (slack.near / per_stiffness)
        size = jnp.where(slack.taut, size, of_slack)
    jump = jnp.where(free, pieces.free - pieces.linear, 0.0)
    if eased is not None:
        moves = eased if slack is None else eased | ~slack.taut
        stiff, jump, size = (jnp.where(moves, x, 0.0) for x in (stiff, jump, size))
    return _OfViscosity(stiff, jump, size, by_near)


def _slopes_of_correction(given: Given, values: Values, pieces: _Pieces):
    """dC/dT of the three tensions; C with f = 0 and dC/dnu^2, both 0 where a cut or a joint is."""
    assert values.tension is not None
    tension = values.tension[1]
    correction, straight = _uncut(given, values, pieces)
    rest = 1.0 - pieces.smooth.rough * pieces.smooth.rough
    share = rest * (pieces.nu2 - 1.0) * (1.0 / 12.0)
    joints = [inside for inside in given.off_joint if inside is not None]
    for inside in joints:
        share = jnp.where(inside, share, 0.0)
    own = -2.0 * share
    if given.taut is not None:
        own = jnp.where(correction > -tension, own, -1.0)
    own = settled(own)
    uncut = own != -1.0  # which no -2 (1 - f)(nu^2 - 1) / 12 is
    share = jnp.where(uncut, -0.5 * own, 0.0)
    for inside in joints:
        uncut = uncut & inside
    bend = _bend(values) * (1.0 / 12.0)
    straight, bend = (jnp.where(uncut, x, 0.0) for x in (straight, rest * bend))
    return (share, own, share), straight, bend
