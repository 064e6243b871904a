"""The start of lines that winches keep taut and of bodies that run on them."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import (
    Coupled,
    Found,
    body_force,
    live_line,
    paid_out,
    posts_of,
    winch_of,
)
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.forces import node_frame
from lumpedcable.model.line import placed
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net, make_net
from lumpedcable.model.riders import Rider
from lumpedcable.model.turned import turned
from lumpedcable.model.winches import Winch
from lumpedcable.physics.bisection import bisected
from lumpedcable.physics.coupling import IdealCable, Posts, PostState
from lumpedcable.physics.motion import Still
from lumpedcable.physics.tension import strain_at
from lumpedcable.physics.vectors import size
from lumpedcable.solve.paidout import hangs, hung_length, hung_line, swept
from lumpedcable.solve.softening import Stages
from lumpedcable.solve.statics import (
    Equilibrium,
    force_scale,
    forces_at_rest,
    held_position,
    norm,
    worst,
)

__all__ = ["Unknowns", "carried_equilibrium", "dimensions_of", "is_carried", "span_of"]

HALVINGS = 80
EVENINGS = (
    20  # of segments beside a trolley, each of which leaves less than half of what was uneven
)
MOST_STRAIN = 0.1  # of softer lines on winches


def is_carried(model: Model) -> bool:
    """Whether a model has winches or bodies on cables."""
    return any(isinstance(body, Rider | Winch) for body in model.bodies.values())


class Unknowns(NamedTuple):
    """What can move: all places (m), then bodies, each a name and a direction of its coordinates (m,).

    `d` is the number of the scene's dimensions; a scene of ideal lines alone has no net.
    """

    net: Net | None
    slots: tuple[tuple[str, Array], ...]
    d: int

    @property
    def nodal(self) -> int:
        """Number of those that belong to places."""
        return 0 if self.net is None else self.net.size * self.d

    @property
    def size(self) -> int:
        """Number of all."""
        return self.nodal + len(self.slots)

    def split(self, model: Model, x: Array) -> dict[str, Array]:
        """Displacements by line and body."""
        lines = {}
        if self.net is not None:
            lines = self.net.spread(x[: self.nodal].reshape(-1, self.d))
        moved = dict(lines)
        for name, body in model.bodies.items():
            moved[body_key(name)] = jnp.zeros_like(body.reference)
        for k, (name, way) in enumerate(self.slots, self.nodal):
            moved[body_key(name)] = moved[body_key(name)] + x[k] * way
        return moved

    def acting(self, model: Model, x: Array) -> tuple[Array | None, Found]:
        """Net force (N) on every place (places, d), without what holds it, and what makes it up."""
        moved, t = self.split(model, x), jnp.zeros(())
        model = turned(model, None, moved)
        found, force = Found(), None
        live = {name: live_line(model, name, moved, None) for name in model.lines}
        for name, line in live.items():
            forces = line.forces(moved[name], None)
            found[name] = Evaluation(forces, node_frame(model, line, forces.shape), (), ())
        found.add_couplings(model, t, moved, None)
        found.add_passing(model, t, None, None)
        if self.net is not None:
            own = eqx.tree_at(lambda m: m.lines, model, live)
            force = forces_at_rest(own, x[: self.nodal].reshape(-1, self.d), self.net)
            extra = {n: jnp.zeros_like(line.reference) for n, line in live.items()}
            for coupled, pull in zip(model.couplings, found.pulls, strict=True):
                if coupled.line is not None and pull.line is not None:
                    extra[coupled.line] = extra[coupled.line] + pull.line
            force = force + self.net.gather(extra)
        return force, found

    def forces(self, model: Model, x: Array) -> Array:
        """Net force (N) on every place, without what holds it, and in the directions of bodies.

        On bodies that is all but the pull of lines that are tied to them.
        """
        moved, parts, forces = self.split(model, x), [], {}
        acting, found = self.acting(model, x)
        if acting is not None:
            parts.append(acting.ravel())
        for name, way in self.slots:
            if name not in forces:
                body = model.bodies[name]
                q = body.reference + moved[body_key(name)]
                force = body.force(q, jnp.zeros_like(q))
                pull = body_force(model, name, found, moved)
                forces[name] = force if pull is None else force + pull
            parts.append(jnp.dot(way, forces[name])[None])
        return jnp.concatenate(parts)

    def residual(self, model: Model, x: Array) -> Array:
        """The same, with -x on places that are held."""
        force = self.forces(model, x)
        if self.net is None:
            return force
        held = jnp.repeat(jnp.asarray(self.net.fixed), self.d)
        return jnp.where(jnp.pad(held, (0, len(self.slots))), -x, force)


def span_of(model: Model, name: str) -> Float[Array, " d"]:
    """The level direction from post to post of the line that a body runs on."""
    coupled = next(coupled for coupled in model.couplings if coupled.body == name)
    posts = posts_of(model, coupled, jnp.zeros(()), None, None)
    if posts is not None:
        way = posts.end.place - posts.start.place
    else:
        assert coupled.line is not None  # only an ideal cable has no nodes
        nodes = model.lines[coupled.line].reference
        way = nodes[:, -1] - nodes[:, 0]
    way = way.at[-1].set(0.0)
    return way / size(way)


def _found(model: Model, name: str) -> list[Array]:
    """What statics finds of a body: a winch's length, a trolley's height and in space its way aside."""
    body = model.bodies[name]
    none = jnp.zeros_like(body.reference)
    if isinstance(body, Winch):
        return [none.at[0].set(1.0)]
    if not isinstance(body, Rider) or not body.settles:
        return []
    found = [none.at[body.dimensions - 1].set(1.0)]
    if body.dimensions == 3:
        span = span_of(model, name)
        found.append(none.at[0].set(-span[1]).at[1].set(span[0]))
    return found


def carried_equilibrium(
    model: Model, tolerance: Float[Array, ""], max_iterations: int
) -> Equilibrium:
    """The model with its lines at rest under their winches, trolleys held where they start along them.

    Newton's method with the whole Jacobian, from straight parts between post, trolley and post, or from
    the line's own hanging shape where no trolley runs on it; the last step carries the derivative, its
    Jacobian frozen.
    """
    model = _guessed(model)
    slots = tuple((name, way) for name in model.bodies for way in _found(model, name))
    net = make_net(model, ordered=False) if model.lines else None
    unknowns = Unknowns(net, slots, dimensions_of(model))
    size = unknowns.size
    if size == 0:  # all that there is starts where the scene puts it
        none = jnp.zeros(())
        return Equilibrium(model, none, none == 0.0, jnp.zeros((), int))
    frozen = jax.lax.stop_gradient(model)
    scale = _scale(frozen)
    goal = tolerance * scale + _rounding(frozen)
    x, force, slope, count = _searched(frozen, unknowns, goal, max_iterations)
    left = worst(force)
    # a singular slope is replaced beforehand: what is infinite has no way back, whether chosen or not
    regular = jnp.all(jnp.isfinite(jnp.linalg.solve(slope, force)))
    last = x - jnp.linalg.solve(
        jnp.where(regular, slope, jnp.eye(size)), unknowns.residual(model, x)
    )
    x = jnp.where(regular & jnp.all(jnp.isfinite(last)), last, x)
    return Equilibrium(_settled(model, unknowns.split(model, x)), left / scale, left <= goal, count)


def _searched(
    model: Model, unknowns: Unknowns, goal: Float[Array, ""], max_iterations: int
) -> tuple[Array, Array, Array, Array]:
    """What `unknowns` are at rest (m), the forces there (N), their slopes (N/m), and the steps taken.

    The parts are taut: steps are Newton's own but where one of them goes wrong. What is not found at
    once is looked for again in stages of softer lines (`solve.softening`). Nothing of it has a
    derivative.
    """
    pulls = [body.tension for body in model.bodies.values() if isinstance(body, Winch)]
    softest = jnp.max(jnp.stack(pulls)) / MOST_STRAIN if pulls else None
    stages = Stages.of(model, max_iterations, softest=softest)

    def sloped(x, stage):
        def both(x):
            force = unknowns.residual(stages.model(model, stage), x)
            return force, force

        slope, force = jax.jacfwd(both, has_aux=True)(x)
        return x, force, slope

    def unfinished(carry):
        (_, force, _), _, stage, _ = carry
        return stages.unfinished(stage, worst(force) <= goal)

    def step(carry):
        kept, (trial, share), stage, count = carry
        after = sloped(trial, stage)
        begins = stages.begins(stage)
        better = norm(after[1]) <= jnp.maximum(norm(kept[1]), goal)
        share = jnp.where(better, jnp.minimum(1.0, 2.0 * share), 0.25 * share)
        share = jnp.where(begins, 1.0, share)
        kept = jax.tree.map(lambda new, old: jnp.where(better | begins, new, old), after, kept)
        x, force, slope = kept
        ahead = x - share * jnp.linalg.solve(slope, force)
        stage, trial = stages.after(stage, worst(force) <= goal, x, ahead)
        return kept, (trial, share), stage, count + 1

    size = unknowns.size
    x, none = jnp.zeros(size), jnp.zeros((), int)
    start = (
        (x, jnp.full(size, jnp.inf), jnp.zeros((size, size))),
        (x, jnp.ones(())),
        stages.first,
        none,
    )
    found, *_, looks = jax.lax.stop_gradient(jax.lax.while_loop(unfinished, step, start))
    return *found, looks - 1


def dimensions_of(model: Model) -> int:
    """Number of dimensions that a model with lines or bodies on lines is computed in."""
    for line in model.lines.values():
        return line.dimensions
    return next(b.dimensions for b in model.bodies.values() if isinstance(b, Rider))


def _settled(model: Model, moved: dict[str, Array]) -> Model:
    """The model with its references where everything is."""
    bodies = {
        name: eqx.tree_at(lambda b: b.reference, body, body.reference + moved[body_key(name)])
        for name, body in model.bodies.items()
    }
    lines = {}
    for name in model.lines:
        live = live_line(model, name, moved, None)
        lines[name] = placed(live, live.reference + moved[name])
    return eqx.tree_at(lambda m: (m.lines, m.bodies), model, (lines, bodies))


def _scale(model: Model) -> Float[Array, ""]:
    sizes = [force_scale(model)]
    for body in model.bodies.values():
        force = body.force(body.reference, jnp.zeros_like(body.reference))
        sizes.append(jnp.max(jnp.abs(force)))
    return jnp.max(jnp.stack(sizes))


def _rounding(model: Model) -> Float[Array, ""]:
    """Force (N) that the last digit of a place can make up, the stiffness of a segment times it."""
    sizes = [jnp.zeros(())]
    for line in model.lines.values():
        stiff = (
            jnp.abs(line.law.tension(jnp.asarray(1e-6)) - line.law.tension(jnp.zeros(()))) / 1e-6
        )
        far = jnp.max(jnp.abs(line.reference))
        sizes.append(stiff * (1.0 + far / jnp.min(line.segment_length)))
    return 32.0 * jnp.finfo(jnp.float64).eps * jnp.max(jnp.stack(sizes))


# --- first shapes ---------------------------------------------------------------------------


def _guessed(model: Model) -> Model:
    """Trolleys at the height at which an ideal cable would carry them, lines straight to them."""
    bodies, lines = dict(model.bodies), dict(model.lines)
    ways: dict[str, list[Array]] = {}
    for coupled in model.couplings:
        body = bodies[coupled.body]
        assert isinstance(body, Rider)
        law, posts = _ideal(model, coupled)
        if body.settles:
            body = _at_rest(body, law, posts)
            bodies[coupled.body] = body
        if coupled.line is not None:
            ways.setdefault(coupled.line, []).append(body.reference[: body.dimensions])
    for name in model.lines:
        winch = winch_of(model, name)
        if winch is None:
            continue
        posts = [_post(model, name, node) for node in (0, -1)]
        path = jnp.stack([posts[0], *ways.get(name, ()), posts[1]], axis=1)
        along = jnp.concatenate([jnp.zeros(1), jnp.cumsum(size(jnp.diff(path, axis=1)))])
        line = lines[name]
        if name not in ways and hangs(line):
            length = hung_length(model, winch, *posts)
            at, ends = jax.lax.stop_gradient((model, posts))
            longer = paid_out(swept(at, at.lines[name], *ends), length)
            nodes = hung_line(longer, *ends)
        else:
            nodes = _evenly(path, along, line.segments)
            strain = strain_at(line.law, winch.tension, line.max_strain)
            length = jnp.sum(size(jnp.diff(nodes, axis=1))) / (1.0 + strain)
        nodes = nodes.at[:, 0].set(posts[0]).at[:, -1].set(posts[1])
        lines[name] = placed(paid_out(line, length), nodes)
        key = next(n for n, b in bodies.items() if b is winch)
        paid = winch.reference.at[0].set(length)
        bodies[key] = eqx.tree_at(lambda b: b.reference, winch, paid)
    return eqx.tree_at(lambda m: (m.lines, m.bodies), model, (lines, bodies))


def _evenly(
    path: Float[Array, "d corners"], along: Float[Array, " corners"], segments: int
) -> Float[Array, "d nodes"]:
    """Nodes (m) on a path with corners, as far from each other on a straight way wherever they are.

    Where a corner is between two of them they are nearer to each other by it than along the path, and
    a line that cannot push would begin slack there: from that nothing leads on.
    """

    def nodes(steps):
        at = jnp.concatenate([jnp.zeros(1), jnp.cumsum(steps)]) * (along[-1] / jnp.sum(steps))
        return jnp.stack([jnp.interp(at, along, row) for row in path])

    def evened(_, steps):
        sizes = size(jnp.diff(nodes(steps), axis=1))
        return steps * jnp.mean(sizes) / sizes

    return nodes(jax.lax.fori_loop(0, EVENINGS, evened, jnp.ones(segments)))


def _post(model: Model, line: str, node: int) -> Float[Array, " d"]:
    place = held_position(model, model.end(line, node))
    assert place is not None  # the scene was checked
    return place


def _ideal(model: Model, coupled: Coupled) -> tuple[IdealCable, Posts]:
    """The ideal cable in the place of a line, and its posts."""
    if isinstance(coupled.law, IdealCable):
        posts = posts_of(model, coupled, jnp.zeros(()), None, None)
        assert posts is not None
        return coupled.law, posts
    assert coupled.line is not None
    winch = winch_of(model, coupled.line)
    assert winch is not None
    places = [_post(model, coupled.line, node) for node in (0, -1)]
    posts = Posts(*(PostState(place, jnp.zeros_like(place), False) for place in places))
    return IdealCable(Still(places[0]), Still(places[1]), winch.tension), posts


def _at_rest(body: Rider, law: IdealCable, posts: Posts) -> Rider:
    """The body at the height at which the cable carries it, by bisection; unchanged without weight."""
    q, last = body.reference, body.dimensions - 1
    d, t = body.dimensions, jnp.zeros(())
    places = [post.place for post in posts]
    top = jnp.maximum(places[0][last], places[1][last])
    span = jnp.sqrt(jnp.sum((places[1] - places[0]) ** 2))

    def carries(z):
        at = q.at[last].set(z)
        pull = law.pull(t, at[:d], None, posts).body[last]
        return pull + body.force(at, jnp.zeros_like(at))[last] > 0.0

    low, _ = bisected(carries, top - 1e3 * span, top + span, HALVINGS)
    return eqx.tree_at(lambda b: b.reference, body, q.at[last].set(low))
