"""The state of rest as a function of what is changed around it, for Newton's method on that.

Lengths that meet targets and places of bodies at rest are found alike: roots x of conditions on the
state of rest, looked for on a scene without derivatives, and one more step that has them.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.assemble import assemble
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.model import Model, Vectors
from lumpedcable.physics.place import place_at_end
from lumpedcable.scene import Scene
from lumpedcable.scene.part import Part, children
from lumpedcable.solve.carried import is_carried
from lumpedcable.solve.start import Places, at_places, start_of
from lumpedcable.solve.statics import Equilibrium, equilibrium, held_position, laid_out_exactly

__all__ = ["finished", "frozen", "nodes_of", "rest_near"]


def nodes_of(model: Model) -> Vectors:
    """Where the nodes of each line are (m)."""
    return {name: line.reference for name, line in model.lines.items()}


def rest_near(
    scene: Scene,
    layout: Layout,
    coordinates: Coordinates,
    nodes: Vectors,
    places: Places | None = None,
) -> Equilibrium:
    """The state of rest, looked for from nodes (m) that are near it; `places` as of `start_of`.

    Lines without joints between them are laid out from nothing, but for other places of bodies alone:
    that is sure, and stays so where a line from before hangs slack because it has become longer. Rods go
    through their stages each time, and lines on winches and what runs on them are found anew.
    """
    model = at_places(assemble(scene, layout, coordinates), places)
    rods = any(line.inextensible for line in model.lines.values())
    anew = places is None and not model.junctions
    if rods or anew or is_carried(model) or laid_out_exactly(model):
        return start_of(scene, layout, coordinates, places)
    near = _carried_along(model, nodes) if places else dict(jax.lax.stop_gradient(nodes))
    for name, node, end in model.outer_ends():
        held = held_position(model, end)
        if held is not None:  # a place of the scene's own, which has its derivatives
            near[name] = place_at_end(near[name], node, held)
    model = model.placed(near)
    tolerance = jnp.asarray(scene.statics.tolerance, float)
    return equilibrium(model, tolerance, scene.statics.max_iterations, near=True)


def _carried_along(model: Model, nodes: Vectors) -> Vectors:
    """Nodes (m) of lines whose ends have moved: the others by so much less as they are farther away."""
    moved = dict(nodes)
    for name, node, end in model.outer_ends():
        held = held_position(model, end)
        if held is not None:
            share = jnp.linspace(0.0, 1.0, nodes[name].shape[1])
            share = share if node else 1.0 - share
            moved[name] = moved[name] + (held - nodes[name][:, node])[:, None] * share
    return jax.lax.stop_gradient(moved)


def frozen(value: Any) -> Any:
    """A part of a scene whose numbers carry no derivatives."""
    if isinstance(value, Part):
        return value.model_copy(update={str(key): frozen(v) for key, v in children(value)})
    if isinstance(value, dict):
        return {key: frozen(v) for key, v in value.items()}
    if isinstance(value, tuple):
        return tuple(map(frozen, value))
    return jax.lax.stop_gradient(value) if isinstance(value, jax.Array) else value


def finished(
    at: Callable[[Float[Array, " n"]], tuple[Float[Array, " n"], Equilibrium]],
    x: Float[Array, " n"],
    slope: Float[Array, "n n"],
    size: Float[Array, " n"],
) -> tuple[Float[Array, " n"], Equilibrium]:
    """What is left of the conditions at a root that was found, and the state of rest there.

    By the step that carries the derivative; where it is more than rounding beside `size`, Newton did
    not end, and x stays.
    """

    def finish(x, _):
        miss, found = at(x)
        change = jnp.linalg.solve(slope, -miss)
        near = jnp.all(jnp.abs(change) <= 1e-6 * size)
        return x + jnp.where(near, change, 0.0), (miss, found)

    # twice in one loop, for x and for the state that goes with it: half as much to compile
    _, every = jax.lax.scan(finish, x, None, length=2)
    return jax.tree.map(lambda both: both[-1], every)
