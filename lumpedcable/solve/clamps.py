"""Lines at rest without folds: first shapes that have none, and a look at what was found.

Pointed backwards into its clamp or folded back on itself, a line that bends is at rest as well, as a
pencil on its tip is. Newton's method finds that state where it begins near it.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.model.splices import Spliced, meeting, spliced
from lumpedcable.physics.bending import Bending, upright
from lumpedcable.physics.bisection import bisected
from lumpedcable.physics.linear import differences
from lumpedcable.physics.load import Shape
from lumpedcable.physics.seabed import AbstractSeabed
from lumpedcable.physics.vectors import dot, size
from lumpedcable.solve.hanging import nodal_weight, spanning_line

__all__ = ["arched", "bent_out", "folded", "opened_out", "pushes_on_bed", "stiffened"]

ASIDE = 0.1
"""Part that a first shape goes aside where it turns, since between opposite directions there is none."""

STRUT = 1e-6
"""Push over the largest tension from which on a segment that is turned back is a strut."""

DRAWN, LONGEST = 256, 8.0
"""Points of an arch, and its clamps' arms over the line's length at most."""

ROOM, WIDEST = 3.0, 0.6
"""Width of a loop over (EI / w)^(1/3), and at most over the line's length."""


def bent_out(
    line: Line, path: Float[Array, "d nodes"], pull: Float[Array, " d"], held: tuple[bool, bool]
) -> Float[Array, "d nodes"]:
    """The path (m), led out of clamps that it would leave backwards.

    There its tangent t becomes that of (1 - w) t + w c, c the clamp's and w = exp(-s/b) over the length
    s (m) from it, with b = sqrt(EI / F) at least two segments, in which a beam under weight and pull F
    takes its direction. Between opposite directions there is no turn: it goes aside a little (`ASIDE`).

    Args:
        line: the line.
        path: places (m) of its nodes.
        pull: at its free end (N).
        held: whether its start and its end stay where they are; one of them at least.
    """
    bending, clamps = line.bending, line.clamps
    if bending is None or not clamps:
        return path
    step = jax.lax.stop_gradient(differences(path))  # a state of rest does not depend on a guess
    length = jnp.sqrt(dot(step, step))
    tangent = step / jnp.maximum(length, 1e-300)
    total, middle = jnp.sum(length), jnp.cumsum(length) - 0.5 * length
    load = size(jnp.sum(nodal_weight(line), axis=1)) + size(pull)
    fade = jnp.maximum(jnp.sqrt(bending.EI / jnp.maximum(load, 1e-300)), 2.0 * jnp.max(length))
    fade = jnp.minimum(fade, total)
    led = tangent
    for node, clamp in clamps.items():
        away = middle if node == 0 else total - middle
        share = jnp.where(jnp.dot(tangent[:, node], clamp) < 0.0, jnp.exp(-away / fade), 0.0)
        led = (1.0 - share) * led + share * clamp[:, None]
        led = led + ASIDE * share * (1.0 - share) * _across(clamp)[:, None]
    led = led / jnp.maximum(jnp.sqrt(dot(led, led)), 1e-300)
    moved = path[:, :1] + jnp.pad(jnp.cumsum(led * length, axis=1), ((0, 0), (1, 0)))
    missed = path[:, -1:] - moved[:, -1:]
    if held == (True, True):
        return moved + jnp.concatenate([jnp.zeros(1), jnp.cumsum(length)]) / total * missed
    return moved if held[0] else moved + missed


def opened_out(
    line: Line, start: Float[Array, " d"], end: Float[Array, " d"]
) -> Float[Array, "d nodes"]:
    """First shape (m) between two places (m) of a line that bends: hanging, with room for its turn.

    A loop under a weight of w (N/m) is some (EI / w)^(1/3) wide. Between ends that are nearer than
    `ROOM` times that, a line without bending hangs in a fold, in which one that bends can be at rest as
    well. Here it hangs between ends so far apart, across w, and is brought together evenly: a balloon.
    """
    bending = line.bending
    if bending is None or line.dimensions == 1:
        return spanning_line(line, start, end)
    length = jnp.sum(jnp.broadcast_to(line.segment_length, (line.segments,)))
    span, weight = jax.lax.stop_gradient((end - start, jnp.sum(nodal_weight(line), axis=1)))
    heavy = size(weight)
    down = weight / jnp.maximum(heavy, 1e-300)
    level = span - jnp.dot(span, down) * down
    gap = size(level)
    away = jnp.where(gap > 1e-9 * length, level / jnp.maximum(gap, 1e-300), _across(down))
    room = ROOM * jnp.cbrt(bending.EI * length / jnp.maximum(heavy, 1e-300))
    room = jnp.minimum(room, WIDEST * length)
    more = jax.lax.stop_gradient(jnp.maximum(room - gap, 0.0)) * away
    path = spanning_line(line, start, end + more)
    shares = jnp.linspace(0.0, 1.0, line.segments + 1)
    return path - more[:, None] * shares


def stiffened(
    line: Line, path: Float[Array, "d nodes"], pull: Float[Array, " d"], from_start: bool
) -> Float[Array, "d nodes"]:
    """The path, or a straight line out of the clamp (m) if its end turns by less than a radian.

    The end of a cantilever turns by W L^2 / (6 EI) under its weight W and by P L^2 / (2 EI) under a
    force P at its end (N).
    """
    bending, clamp = line.bending, line.clamp(0 if from_start else -1)
    if bending is None or clamp is None:
        return path
    along = _along(line)
    straight = path[:, :1] + clamp[:, None] * along
    if not from_start:
        straight = path[:, -1:] - clamp[:, None] * (along[-1] - along)
    return jnp.where(_turn(line, bending, pull) < 1.0, straight, path)


def arched(line: Line, path: Float[Array, "d nodes"]) -> Float[Array, "d nodes"]:
    """The path, or an arch (m) between two clamps if bending decides its shape, as in `stiffened`.

    The arch is a Bezier curve between the places a, b (m) out of and into the clamps' directions c, d,
    x(u) = (1 - u)^3 a + 3 (1 - u)^2 u (a + h c) + 3 (1 - u) u^2 (b - h d) + u^3 b, with arms h (m) that
    give it the line's length, 0 if the places are too far apart. It leaves its clamps forwards, which a
    line that hangs may not.
    """
    bending, start, end = line.bending, line.clamp(0), line.clamp(-1)
    if bending is None or start is None or end is None or line.dimensions == 1:
        return path
    along = _along(line)
    total = along[-1]
    a, b, c, d = (x[:, None] for x in (path[:, 0], path[:, -1], start, end))
    u = jnp.linspace(0.0, 1.0, DRAWN)

    def drawn(arm):
        between = (1.0 - u) ** 2 * (1.0 + 2.0 * u) * a + u**2 * (3.0 - 2.0 * u) * b
        return between + 3.0 * arm * u * (1.0 - u) * ((1.0 - u) * c - u * d)

    def distances(arm):
        step = differences(drawn(arm))
        return jnp.concatenate([jnp.zeros(1), jnp.cumsum(jnp.sqrt(dot(step, step)))])

    arm, _ = bisected(lambda h: distances(h)[-1] < total, jnp.zeros(()), LONGEST * total, 50)
    reached = distances(arm)
    at = along / total * reached[-1]
    arch = jax.vmap(lambda x: jnp.interp(at, reached, x))(drawn(arm))
    moved = jax.lax.stop_gradient(arch - path)  # ends keep the derivatives of their places
    return jnp.where(_turn(line, bending, jnp.zeros_like(start)) < 1.0, path + moved, path)


def _along(line: Line) -> Float[Array, " nodes"]:
    """How far along the line its nodes are (m)."""
    full = jnp.broadcast_to(line.segment_length, (line.segments,))
    return jnp.concatenate([jnp.zeros(1), jnp.cumsum(full)])


def _turn(line: Line, bending: Bending, pull: Float[Array, " d"]) -> Float[Array, ""]:
    """How far (rad) the end of a cantilever turns under the line's weight and a force at its end (N)."""
    sizes = [jnp.sqrt(jnp.sum(f**2)) for f in (jnp.sum(nodal_weight(line), axis=1), pull)]
    return (sizes[0] / 6.0 + sizes[1] / 2.0) * _along(line)[-1] ** 2 / bending.EI


def _across(direction: Float[Array, " d"]) -> Float[Array, " d"]:
    """A direction at a right angle to another (d of 2 or 3)."""
    axis = jnp.eye(len(direction))[jnp.argmin(jnp.abs(direction))]
    across = axis - jnp.dot(axis, direction) * direction
    return across / jnp.sqrt(jnp.dot(across, across))


def pushes_on_bed(line: Line) -> bool:
    """Whether an elastic line on a bed can push."""
    on_bed = any(isinstance(load, AbstractSeabed) for load in line.loads)
    return on_bed and not line.tension_only and not line.inextensible


def folded(model: Model) -> Bool[Array, ""]:
    """Whether a line at rest is folded back on itself, or into a clamp, where a touch would open it.

    On a bed, where the nodes of a slack line are crowded, a segment that pushes and is turned back upon
    its neighbour is a strut that gives way; of lines that bend see `_opens`.
    """
    found = jnp.zeros((), bool)
    for line in model.lines.values():
        pushes = pushes_on_bed(line)
        if not pushes and line.bending is None:
            continue
        shape = line.shape()
        tension = line.law.tension(shape.strain)
        turn = dot(shape.tangent[:, 1:], shape.tangent[:, :-1])
        if pushes:
            least = jnp.minimum(tension[1:], tension[:-1])
            strut = least < -STRUT * jnp.max(jnp.abs(tension))
            found |= jnp.any((turn < 0.0) & strut)
        if line.bending is not None:
            found |= _opens(line, line.bending, shape, jnp.maximum(tension, 0.0), turn)
    for each in spliced(model):
        found |= _joint_opens(model, each)
    return found


def _joint_opens(model: Model, each: Spliced) -> Bool[Array, ""]:
    """Whether two lines that bend as one open at a touch where they meet, as `_opens` has it."""
    lines = {name: (model.lines[name], node) for name, node in each.ends}
    shapes = {name: line.shape() for name, (line, _) in lines.items()}
    sides = meeting(model, each, shapes)
    pulls = [
        jnp.maximum(line.law.tension(shapes[name].strain)[node], 0.0)
        for name, (line, node) in lines.items()
    ]
    most = jnp.maximum(*pulls)
    length = jnp.maximum(*(side.shape.length[side.node] for side in sides))
    return -upright(*sides) > most * length + jnp.sqrt(jnp.minimum(sides[0].EI, sides[1].EI) * most)


def _opens(
    line: Line, bending: Bending, shape: Shape, pull: Float[Array, " n"], turn: Float[Array, " n-1"]
) -> Bool[Array, ""]:
    """Whether a line that bends opens at a touch, under the pulls T (N) of its segments.

    The segment at a clamp turns like a pendulum: T rights it with T l at most, and the clamp turns it
    over with -(EI / s) t . c, l and s = l / 2 the lengths of `Bending` (m). Two segments at a joint
    open with -(EI / s) t . t', `turn` is t . t'; what goes on beyond them rights them with sqrt(EI T),
    as a beam under tension does whose end is turned.
    """
    found = jnp.zeros((), bool)
    for node, clamp in line.clamps.items():
        over = -bending.EI / shape.node_length[node] * jnp.dot(shape.tangent[:, node], clamp)
        found |= over > pull[node] * shape.length[node]
    opens = -bending.EI / shape.node_length[1:-1] * turn
    most = jnp.maximum(pull[1:], pull[:-1])
    length = jnp.maximum(shape.length[1:], shape.length[:-1])
    return found | jnp.any(opens > most * length + jnp.sqrt(bending.EI * most))
