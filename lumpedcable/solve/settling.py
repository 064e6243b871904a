"""Rigid bodies that start at rest: where their lines, weight, water and thrust balance.

With the lines at equilibrium between them, the generalised forces R (N, N m) on the bodies are
functions of their coordinates q. Implicit steps in a pseudo-time, (K + mu k I) dq = R with K = -dR/dq by
the implicit function theorem, end as Newton's method, as those of the lines do (`solve.statics`).
Forces are measured by the largest of the scene, S, moves by the longest line, L, turns by 1 rad and
moments by S times the arm of the farthest point; k is then S / L.

A box stands on its edge in balance, and a pendulum on its head. So where a way leads down mu is not
below what makes every step one downhill, and a state of rest there is left along that way: see `Lie`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.attached import attached_ends, pull_of_lines
from lumpedcable.model.bodies import RigidBody
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import body_force
from lumpedcable.model.layout import Layout
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.net import make_net
from lumpedcable.model.ships import waves_of
from lumpedcable.model.turned import clamp_force
from lumpedcable.physics.afloat import BodyLift
from lumpedcable.physics.bearing import BedBearing
from lumpedcable.physics.coupling import IdealCable
from lumpedcable.physics.vectors import size
from lumpedcable.physics.wave_force import WaveForce
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.solve.carried import Unknowns, is_carried
from lumpedcable.solve.near import finished, frozen, nodes_of, rest_near
from lumpedcable.solve.start import Places, start_of
from lumpedcable.solve.statics import (
    Equilibrium,
    eased,
    force_scale,
    forces_at_rest,
    rounding_force,
)

__all__ = [
    "FARTHEST",
    "Measures",
    "coordinates_of_bodies",
    "ended",
    "places_of_bodies",
    "searched",
    "settled",
]

ITERATIONS = 200
FARTHEST = 0.05  # of the longest line that a body is moved in a step, and rad that it is turned
SMALLEST = 1e-14  # relative move that is rounding
AWAY = 0.02  # rad, or share of the longest line, by which a state that tips over is left
LEAVINGS = 20  # times that one is left: forces without an energy may lead back to it
FLAT = 1e-9  # of the stiffest way: mu is not below it
NEUTRAL = 10.0  # times that: what has no more stiffness has none
LOOSER = 10.0  # times the tolerance of a node's force, for the sum of many


class Lie(NamedTuple):
    """How a state lies: whether a way leads down from it, along `ways`, and the least mu that it wants.

    In the measures above K is W^(1/2) M W^(-1/2) with W the energies that a way in each of them takes
    for one force. Where forces have an energy M is symmetric, and its least eigenvalue, below 0, tells.
    Thrust and drag have none: M = S + A then has an eigenvalue below 0 where that of S is below -|A|
    (by Bauer & Fike, but where other eigenvalues are as near), or where its determinant is, and S alone
    may have one where K has none. `neutral` is a stiffness along the ways that have none, as of a box
    that may turn on the bed: added to K it holds them, since what nothing holds stays where it is.
    """

    tips: Bool[Array, ""]
    ways: Float[Array, " q"]
    mu: Float[Array, ""]
    neutral: Float[Array, "q q"]

    @classmethod
    def of(cls, slope: Float[Array, "q q"], weight: Float[Array, " q"]) -> "Lie":
        """That of a state with the slope -K of its forces."""
        root = jnp.sqrt(weight)
        stiffness = -slope * root[:, None] / root
        stiffness = jnp.where(jnp.all(jnp.isfinite(slope)), stiffness, jnp.eye(root.size))
        even, odd = 0.5 * (stiffness + stiffness.T), 0.5 * (stiffness - stiffness.T)
        values, vectors = jnp.linalg.eigh(even)
        most = jnp.max(jnp.abs(values))
        flat = FLAT * most
        # counted as an eigenvalue below 0 is what is more than neutral
        sign, _ = jnp.linalg.slogdet(stiffness + NEUTRAL * flat * jnp.eye(root.size))
        tips = (values[0] < -NEUTRAL * flat - jnp.linalg.norm(odd)) | (sign < 0.0)
        ways = vectors[:, 0] / root
        ways = ways * jnp.where(jnp.sum(ways) < 0.0, -1.0, 1.0) / jnp.max(jnp.abs(ways))
        loose = jnp.where(jnp.abs(values) <= NEUTRAL * flat, most, 0.0)
        neutral = (vectors * loose) @ vectors.T * root / root[:, None]
        return cls(tips, ways, jnp.where(tips, flat - 1.5 * values[0], flat), neutral)


class Measures(NamedTuple):
    """What coordinates and forces of bodies that settle are measured by, each (q,) but the last.

    1 for coordinates that can change, 0 for held ones; a length (m) or 1 rad; a force (N) or moment
    (N m); the energies of `Lie`; and the largest force (-) that is left where bodies rest.
    """

    free: Float[Array, " q"]
    reach: Float[Array, " q"]
    most: Float[Array, " q"]
    weight: Float[Array, " q"]
    goal: Float[Array, ""]

    @classmethod
    def of(cls, still: Scene, first: Model) -> "Measures":
        """Those of a scene without derivatives, by a model of it whose lines are at rest."""
        names = still.settling
        lines = still.lines.values()
        length = jnp.max(jnp.stack([jnp.asarray(x.unstretched, float) for x in lines]))
        scale = jax.lax.stop_gradient(_scale(first, names))
        free = jnp.concatenate([_free(first, name) for name in names])
        reach = jnp.concatenate([_reach(first, name, length) for name in names])
        most = jnp.concatenate([_most(first, name, scale) for name in names])
        weight = jax.lax.stop_gradient(most * reach / (scale * length))
        goal = LOOSER * (still.statics.tolerance + rounding_force(first) / scale)
        return cls(free, reach, most, weight, goal)

    def forces(self, model: Model, names: list[str]) -> Float[Array, " q"]:
        """Those on the bodies (-), 0 where they are held."""
        return self.free * _forces(model, names) / self.most

    def sloped(self, slope: Float[Array, "q q"]) -> Float[Array, "q q"]:
        """The slope of these forces (-), as if springs held what cannot change."""
        return slope * jnp.outer(self.free, self.free) - jnp.diag(1.0 - self.free)


class Found(NamedTuple):
    """Bodies at x (-), where the nodes of their lines are (m), the slope of the forces on them and what
    is left of these (-), how they lie; and what else was asked for there."""

    x: Float[Array, " q"]
    nodes: Vectors
    slope: Float[Array, "q q"]
    miss: Float[Array, " q"]
    lie: Lie
    beside: Any


def coordinates_of_bodies(model: Model, names: list[str]) -> Float[Array, " q"]:
    """Where bodies are (m, rad), one after the other."""
    return jnp.concatenate([model.bodies[name].reference for name in names])


def places_of_bodies(model: Model, names: list[str], q: Float[Array, " q"]) -> Places:
    """The same by the bodies' names; `model` is any one that has them."""
    found, at = {}, 0
    for name in names:
        count = model.bodies[name].reference.size
        found[name] = q[at : at + count]
        at += count
    return found


def settled(scene: Scene, layout: Layout, coordinates: Coordinates) -> Equilibrium:
    """The scene's model at static equilibrium, with the bodies that settle where they are at rest.

    Its result has derivatives with respect to every number of the scene.
    """
    still, names = frozen(scene), scene.settling
    first = start_of(still, layout, coordinates)
    by = Measures.of(still, first.model)

    def at(mine: Scene, x: Float[Array, " q"], nodes: Vectors):
        """Forces over their sizes (-) where the bodies are at x, and the state of rest of the lines."""
        places = places_of_bodies(first.model, names, x * by.reach)
        found = rest_near(mine, layout, coordinates, nodes, places)
        return by.forces(found.model, names), found

    def look(x, nodes):
        def both(x):
            miss, found = at(still, x, nodes)
            return miss, (miss, found)

        slope, (miss, found) = jax.jacfwd(both, has_aux=True)(x)
        return by.sloped(slope), miss, nodes_of(found.model), found.converged, ()

    start = coordinates_of_bodies(first.model, names) / by.reach
    found = jax.lax.stop_gradient(searched(by, look, start, nodes_of(first.model), ()))
    slope = found.slope - found.lie.neutral
    miss, rest = finished(lambda x: at(scene, x, found.nodes), found.x, slope, jnp.ones_like(start))
    return ended(scene, coordinates, rest, by, miss)


def ended(
    scene: Scene,
    coordinates: Coordinates,
    rest: Equilibrium,
    by: Measures,
    miss: Float[Array, " q"],
) -> Equilibrium:
    """What was found, judged by the forces that are left on the bodies too (-), and met by the waves."""
    left = jnp.max(jnp.abs(miss))
    return rest._replace(
        model=_met_by_waves(scene, coordinates, rest.model, scene.settling),
        imbalance=jnp.maximum(rest.imbalance, left),
        converged=rest.converged & (left <= by.goal),
    )


def searched(
    by: Measures,
    look: Callable[[Float[Array, " q"], Vectors], tuple],
    start: Float[Array, " q"],
    nodes: Vectors,
    beside: Any,
) -> Found:
    """The bodies at rest, from a place (-) and nodes (m) of their lines; no derivatives.

    `look(x, nodes)` is asked for slope and forces (-) at x, the nodes there (m), whether the lines are
    at rest, and more that goes with it, which `beside` has the form of.
    """

    def unfinished(carry):
        (_, _, _, miss, lie, _), _, moved, count, left = carry
        rests = jnp.max(jnp.abs(miss)) <= by.goal
        goes = jnp.where(rests, lie.tips & (left < LEAVINGS), moved > SMALLEST)
        return goes & (count < ITERATIONS)

    def step(carry):
        kept, mu, _, count, left = carry
        x, nodes, slope, miss, lie, _ = kept
        leaves = jnp.max(jnp.abs(miss)) <= by.goal
        change = jnp.linalg.solve(jnp.maximum(mu, lie.mu) * jnp.eye(x.size) - slope, miss)
        change = jnp.where(jnp.isfinite(change), change, 0.0)
        change = jnp.where(leaves, AWAY * lie.ways, change) * by.free
        share = jnp.minimum(1.0, FARTHEST / jnp.maximum(jnp.max(jnp.abs(change)), 1e-300))
        new_slope, new_miss, new_nodes, good, more = look(x + share * change, nodes)
        usable = good & jnp.all(jnp.isfinite(new_slope)) & jnp.all(jnp.isfinite(new_miss))
        ratio = jnp.linalg.norm(new_miss) / jnp.maximum(jnp.linalg.norm(miss), 1e-300)
        ratio = jnp.where(jnp.all(jnp.isfinite(miss)), ratio, 1.0)
        # away from where it tips over forces grow on the way down
        ratio = jnp.where(lie.tips, jnp.minimum(ratio, 1.0), ratio)
        mu = eased(mu, jnp.where(usable, ratio, 10.0), share)
        known = usable & jnp.all(jnp.isfinite(miss))
        moved = jnp.where(known, jnp.max(jnp.abs(share * change)), 1.0)
        new_lie = Lie.of(new_slope, by.weight)
        after = Found(x + share * change, new_nodes, new_slope, new_miss, new_lie, more)
        kept = jax.tree.map(lambda new, old: jnp.where(usable, new, old), after, kept)
        return kept, mu, moved, count + 1, left + leaves

    # what is not known moves nothing: the first step looks at the start itself
    slope, miss = -jnp.eye(start.size), jnp.full(start.shape, jnp.inf)
    unknown = Found(start, nodes, slope, miss, Lie.of(slope, by.weight), beside)
    one, none = jnp.ones(()), jnp.zeros((), int)
    return jax.lax.while_loop(unfinished, step, (unknown, one, one, none, none))[0]


def _met_by_waves(scene: Scene, coordinates: Coordinates, model: Model, names: list[str]) -> Model:
    """The model with waves that push bodies where these have settled, on the course that they have."""
    bodies = dict(model.bodies)
    for name in names:
        own, part = _body(model, name), scene.bodies[name]
        if isinstance(own.waves, WaveForce) and isinstance(part, Body):
            waves = waves_of(scene, part, coordinates, own.reference)
            bodies[name] = replace(own, waves=waves)
    return eqx.tree_at(lambda m: m.bodies, model, bodies)


def _body(model: Model, name: str) -> RigidBody:
    body = model.bodies[name]
    assert isinstance(body, RigidBody)  # no other settles
    return body


def _scale(model: Model, names: list[str]) -> Float[Array, ""]:
    """The largest force (N) on lines and bodies, those of the water on a hull left out."""
    cables = (coupled.law for coupled in model.couplings)
    sizes = [force_scale(model), *(law.tension for law in cables if isinstance(law, IdealCable))]
    for body in (_body(model, name) for name in names):
        d = body.translation.size
        still = body.force(body.reference, jnp.zeros_like(body.reference))
        free = jnp.ones_like(still) if body.free is None else body.free
        sizes.append(jnp.linalg.norm((free * still)[:d]))
    return jnp.max(jnp.stack(sizes))


def _free(model: Model, name: str) -> Float[Array, " m"]:
    """1 for coordinates that can change, 0 for those that are held."""
    body = _body(model, name)
    return jnp.ones_like(body.reference) if body.free is None else body.free


def _arm(model: Model, name: str) -> Float[Array, ""]:
    """Distance (m) of a body's farthest point that a line ends at, or a bed or the water bears."""
    points = [jnp.linalg.norm(end.point) for _, _, end in attached_ends(model, name)]
    for load in _body(model, name).loads:
        if isinstance(load, BedBearing):
            points.append(jnp.max(size(load.points)))
        elif isinstance(load, BodyLift):
            points.append(load.form.reach())
    return jnp.maximum(jnp.max(jnp.stack([jnp.zeros(()), *points])), 1e-3)


def _reach(model: Model, name: str, length: Float[Array, ""]) -> Float[Array, " m"]:
    """What a body's coordinates are measured by: a length (m), and 1 rad."""
    body = _body(model, name)
    d = body.translation.size
    return jnp.where(jnp.arange(body.reference.size) < d, length, 1.0)


def _most(model: Model, name: str, scale: Float[Array, ""]) -> Float[Array, " m"]:
    """What the forces on a body are measured by: a force (N), and a moment (N m)."""
    body = _body(model, name)
    d = body.translation.size
    return jnp.where(jnp.arange(body.reference.size) < d, scale, scale * _arm(model, name))


def _forces(model: Model, names: list[str]) -> Float[Array, " q"]:
    """Generalised forces on bodies at rest (N, N m), their lines at equilibrium with them."""
    net = make_net(model, ordered=False)
    d = _body(model, names[0]).translation.size
    still = jnp.zeros((net.size, d))
    if is_carried(model):
        pulls, acting = Unknowns(net if model.lines else None, (), d).acting(model, still.ravel())
    else:
        pulls, acting = forces_at_rest(model, still, net), None
    found = []
    for name in names:
        body = _body(model, name)
        q = body.reference
        force = body.force(q, jnp.zeros_like(q))
        if name in net.tied and pulls is not None:
            force = force + pull_of_lines(model, net, name, pulls, q)
        pushed = clamp_force(model, name, q) if acting is None else body_force(model, name, acting)
        found.append(force if pushed is None else force + pushed)
    return jnp.concatenate(found)
