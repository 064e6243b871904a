"""The first shape of a line that a winch keeps at a tension: hanging between its posts, and how long.

A straight line will not do: at the stiffness of wire rope Newton's method creeps from there, since
every step across the line stretches it.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.couple import paid_out, payout_force
from lumpedcable.model.forces import node_frame
from lumpedcable.model.line import Line, placed
from lumpedcable.model.model import Model
from lumpedcable.model.winches import Winch
from lumpedcable.physics.bisection import bisected
from lumpedcable.physics.tension import strain_at
from lumpedcable.physics.weight import Weight
from lumpedcable.solve.hanging import nodal_weight, spanning_line
from lumpedcable.solve.resting import rested, seabed_of, slope_under

__all__ = ["hangs", "hung_length", "hung_line", "swept"]

LEAST, MOST = -20.0, 2.0  # powers of two, of the slack that is tried, over the posts' distance
FINER = 2.0  # tries to a power
HALVINGS = 45


def hangs(line: Line) -> bool:
    """Whether a line has a load to hang by and a shape that is known: not on a bed with a profile."""
    weighs = any(isinstance(load, Weight) for load in line.loads)
    swept = line.drag is not None and line.current is not None and line.dimensions > 1
    return (weighs or swept) and slope_under(line) is None


def swept(model: Model, line: Line, start: Float[Array, " d"], end: Float[Array, " d"]) -> Line:
    """The line with a weight for the drag of a current on it, were it straight between two points (m).

    Unchanged where there is no current, and over a bed, which knows of weight alone.
    """
    if line.drag is None or line.current is None or model.up is None or model.base is None:
        return line
    if seabed_of(line) is not None:
        return line
    nodes = start[:, None] + (end - start)[:, None] * jnp.linspace(0.0, 1.0, line.segments + 1)
    there = placed(line, nodes)
    still = jnp.zeros_like(nodes)
    drag = inertia.drag_force(node_frame(model, there, there.shape(still)), still)
    assert drag is not None
    mean = jnp.sum(drag, axis=1) / jnp.sum(line.node_length)
    return eqx.tree_at(lambda x: x.loads, line, (*line.loads, Weight(mean)))


def hung_line(line: Line, start: Float[Array, " d"], end: Float[Array, " d"]):
    """Positions (m) of a line between two points (m) under its weight, on the bed where there is one."""
    return rested(line, start, end, spanning_line(line, start, end))


def hung_length(
    model: Model, winch: Winch, start: Float[Array, " d"], end: Float[Array, " d"]
) -> Float[Array, ""]:
    """Length L (m) at which a line between two posts (m) pulls at its winch with what that keeps.

    The root of Q(L) = `payout_force` less the winch's pull, on the taut side: Q falls as L grows, until
    the line's own weight makes it rise again. By trying more and more slack, then by bisection; at least
    the length of a straight line under the winch's tension and its weight. Without derivatives.
    """
    model, winch, start, end = jax.lax.stop_gradient((model, winch, start, end))
    line = swept(model, model.lines[winch.line], start, end)
    chord = jnp.sqrt(jnp.sum((end - start) ** 2))
    heavy = jnp.sqrt(jnp.sum(jnp.sum(nodal_weight(paid_out(line, chord)), axis=1) ** 2))
    least = chord / (1.0 + strain_at(line.law, winch.tension + heavy, line.max_strain))

    def taut(length):
        longer = paid_out(line, length)
        there = placed(longer, hung_line(longer, start, end))
        still = jnp.zeros_like(there.reference)
        own = eqx.tree_at(lambda m: m.lines[winch.line], model, there)
        forces = there.forces(still, None)
        return payout_force(own, winch, forces, {winch.line: still}) > winch.pull

    def slack(power):
        return least + chord * 2.0**power

    def too_short(power):
        return (power < MOST) & taut(slack(power))

    power = jax.lax.while_loop(too_short, lambda power: power + 1.0 / FINER, jnp.asarray(LEAST))
    low = jnp.where(power > LEAST, slack(power - 1.0 / FINER), least)
    low, high = bisected(taut, low, slack(power), HALVINGS)
    # with a tension too low to hold up the line there is none: then nearly straight
    return jnp.where(power < MOST, 0.5 * (low + high), slack(-10.0))
